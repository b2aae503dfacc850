"""The folder that a study grows in, and the index that says what it belongs to."""

from magicsim.workers.run_folder import CONFIG, RunFolder, RunIndex

INDEX, RESULTS, REPORT = "study.json", "results.json", "report.html"
DATA, MODELS, PIECES, TABLES = "data", "models", "pieces", "tables"
"""Folders below it: datasets, what is learned, pieces of other stages, and the result as Parquet."""


class StudyIndex(RunIndex):
    """What a folder's files belong to; those of datasets have a list of their own."""

    kind: str


FOLDER = RunFolder(
    index=INDEX, model=StudyIndex, noun="study", content="study",
    title=f"A study of magicsim, everything in place: `magicsim study {CONFIG}`",
)  # fmt: skip
