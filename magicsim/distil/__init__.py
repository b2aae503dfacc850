"""Makes models of the fast tier: draws touches, renders them truly, trains a network, measures its error."""
