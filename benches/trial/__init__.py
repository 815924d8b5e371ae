"""The trial: campaigns with a hidden effect, diagnosed and scored. `python benches/trial` runs it.

What makes campaigns, without a word of the product (the rig is in tests/reference/rig):
    strength    how far an effect stands out once everything free is refitted
    families    six families of campaigns at a stated strength, each fixed by its seed
    rivals      which effects look alike in a campaign
    oracle      what the one who knows forms and noise would name
What diagnoses them and counts:
    answers     campaigns and answers, kept in out/trial under what they depend on
    grades      how good one answer is, in one word
    score       every measure with its interval and whether it is reached
    page        the score as docs/explanation/trial.md
    run         which campaigns, the run over them, and the command
"""
