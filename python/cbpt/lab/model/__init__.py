"""What is predicted for each reading, and what is plausible beforehand.

priors          variants of effects, plausible sizes, prior odds
spring_priors   the same for a torsion spring
discrepancy     how far an effect may depart from its equation
dataset         readings as the statistics need them
own_loops       what a table's own smaller loops say of a play
forward         the drive with effects on the rows of a data set
own_terms       effects of the user among them
"""
