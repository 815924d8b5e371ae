"""Campaigns to come: simulated, judged, chosen.

plan              loads of a campaign
simulate          what it would read
candidates        runs to choose among
effect_changes    what effects do to a campaign
detection         the smallest change that is seen
design_fit        what is left of a change after a refit
isolability_data  what a campaign could see and tell apart, as data
separation        how far one effect stands out, and two are apart
isolability       all of them: document, text and picture
isolability_text  the same for a terminal
shortest_plan     the shortest campaign
expected_gain     what a further run would bring
"""
