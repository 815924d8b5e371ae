"""Tables of readings.

readings     the table itself: columns in the units of their names
reader       a table from any source
headers      the quantity and unit that the name of a column states
text         tables written as text
in_memory    tables handed over as objects
files        tables in files of other programs: parts finds the tables in what such a file holds,
             apart has it read in a process of its own, child is that process
set_points   the values that a rig was set to
whole_turns  angles of an encoder that begins again after a turn
unit_check   signs that a unit is another than the one stated
inputs       a case and its readings
"""
