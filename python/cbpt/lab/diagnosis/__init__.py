"""The verbs that answer a user, and how the answer is told.

diagnose          which effect is missing
diagnosis         the answer; diagnosis_data, the same as data; ranking, single effects side by side
by_level          an answer for each level of a column
fitted            effects added to a case
next_runs         the run that would decide; deciding_runs, the same for a diagnosis
compare           the model against the readings; comparison_data, comparison_text, misfit
why               the answer against each rival, split by readings
alternatives      what an answer may have missed
noise_statement   what the answer says of the noise
sparse_term       a formula for what is unknown
unexplained       what is known of what is unknown
report, sentence  the answer in words; fit_text, a fit in words
"""
