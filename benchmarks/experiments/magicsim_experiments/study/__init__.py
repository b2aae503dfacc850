"""Studies: protocols of published experiments, run on any design, from a TOML file to tables, figures and one page.

`magicsim_experiments.study.protocol` says what a study is, `study_file` lists those there are.
"""
