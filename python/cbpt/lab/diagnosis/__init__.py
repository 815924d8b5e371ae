"""The verbs that answer a user, and how the answer is told.

diagnose          which effect is missing
diagnosis         the answer
by_level          an answer for each level of a column
fitted            effects added to a case
compare           the model against the readings, and comparison_text, its report
alternatives      what an answer may have missed
noise_statement   what the answer says of the noise
sparse_term       a formula for what is unknown
unexplained       what is known of what is unknown
report, sentence  the answer in words
"""
