"""The figures by which makers and standards describe a torque-angle loop.

characterise      a case and its readings -> Characteristics
characteristics   the answer: figures with uncertainties; record and text, what it is made of
loops             legs between turns of the torque, and branches that make a loop
figures           what is read off a loop, each by its definition
three_pieces      K1, K2, K3 and the break torques between them
uncertainty       type A from repeats and runs, type B from [uncertainty]
simulated         loops of the model with its effects
warnings          what makes a figure less than it seems
"""
