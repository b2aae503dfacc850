"""Stages of studies: what each computes and leaves in the folder, so that a run that was killed goes on."""
