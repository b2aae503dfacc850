"""How equilibria are found: Newton iterations, searches, load steps and what is tried when one fails."""
