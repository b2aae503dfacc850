"""The page on which the designs of a sweep are explored, and the trends it states."""
