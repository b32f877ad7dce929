"""The parts of benchmarks/run.py: problems, systems, the judge of final costs, tables, plots."""
