"""Many independent tasks on many processes: one machine's cores, or a cluster's, behind one function."""
