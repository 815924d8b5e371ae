"""The trial: campaigns with a hidden effect, diagnosed and scored. `python benches/trial` runs it.

What makes campaigns, without a word of the product (the rig is in tests/reference/rig):
    strength    how far an effect stands out once everything free is refitted
    families    six families of campaigns at a stated strength, each fixed by its seed
    rivals      which effects look alike in a campaign
    oracle      what the one who knows forms and noise would name
    wider       families that the six do not see: effects under every noise, two and three of them,
                coarse displays, artefacts, small and lawless tables; spring_sets: torsion springs
    candidates  every form of the rig's effects in one campaign
    evidence    the oracle of sets: evidence of all singles, pairs and triples, and what it says
What diagnoses them and counts:
    answers     campaigns and answers, kept in out/trial under what they depend on
    adapter     what an answer says, whatever the version of its document
    grades      how good one answer is, in one word
    claims      what it claims against what is hidden, in the wider families
    score       every measure with its interval and whether it is reached
    targets     what the second version of the answer has to reach
    page        the score as docs/explanation/trial.md
    run         which campaigns, the run over them, and the command
"""
