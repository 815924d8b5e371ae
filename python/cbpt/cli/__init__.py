"""The command line.

main        hands a verb to Rust or to one of the others
options     what the verbs share: parsers, flags, answers printed
lab         compare, diagnose, fit
campaigns   simulate, isolability, next-run, plan
design      tolerance, optimise
page        report, workbench
sweep       a sweep to Parquet
"""
