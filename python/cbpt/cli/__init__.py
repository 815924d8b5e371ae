"""The command line: main hands a verb to Rust or to one of the others."""
