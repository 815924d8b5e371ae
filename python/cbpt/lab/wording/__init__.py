"""Names, numbers and units as text.

names      effects and columns of readings in words
numbers    numbers rounded for people, parameters in their usual units, words in a row
phrases    parts of sentences that many have: the first few of many, a range
layout     tables and prose that fit the terminal
inline     the page of a result, for a notebook
html       what results show of themselves in a notebook
versions   what an answer was made with
"""
