"""Pictures with matplotlib, drawn from what they are handed; nothing here knows the lab.

comparison    readings and model over the torque, the residual below
diagnosis     readings and model, the residuals before and after, how the error falls
isolability   which effects look alike
tolerance     the angle of drives within their tolerances
shared        readings as points, colours, files
"""
