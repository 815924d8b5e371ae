"""What is predicted for each reading, and what is plausible beforehand.

priors          forms of effects, plausible sizes, prior odds
spring_priors   the same for a torsion spring
discrepancy     how far an effect may depart from its form
own_terms       effects of the user among them
forward         the drive with effects on the rows of a table
"""
