"""Sparsity of the lattice's Hessian: upper triangle in 3 x 3 blocks, rows compressed."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array, Index, Indices, Mask
from magicsim.deform.lattice.structure import Lattice

NO_PATCHES = np.empty((0, 1), np.int64)


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockPattern:
    """Compressed rows of the upper triangle over the free nodes' unknowns."""

    size: int
    indptr: Indices
    """Start of each row, shape (size + 1,)."""
    indices: Indices
    """Column of each entry, ascending in a row, shape (entries,)."""
    blocks: Indices
    """Place of the block of two corners within its block row, -1 where a node is bonded, shape (cells, 8, 8)."""
    patch_blocks: Indices
    """Place of the block of two nodes of a patch of the contact face, shape (patches, nodes a patch, nodes a patch)."""
    held: Mask
    """Unknowns that stay zero, shape (size,)."""
    held_entries: Indices
    """Entries in their rows and columns."""

    def hold(self, values: Array) -> None:
        """Turns the rows and columns of the held unknowns into those of the unit matrix, in place."""
        values[self.held_entries] = 0.0
        values[self.indptr[:-1][self.held]] = 1.0


def block_pattern(lattice: Lattice, patches: Index = NO_PATCHES) -> BlockPattern:
    """Finds where every pair of nodes of a cell, or of a patch of the contact face, goes.

    Entry (3 i + r, 3 j + s) of a block at place k of block row i stands at `indptr[3 i + r] + 3 k + s - r`.

    Contact couples the nodes of a patch, ascending, shape (patches, nodes a patch); the body alone has none.
    """
    free = lattice.free_nodes
    keys = [_pair_keys(lattice.cells, free), _pair_keys(patches, free)]
    pairs = np.unique(np.concatenate([own[own >= 0] for own in keys]))
    block_rows, block_columns = np.divmod(pairs, free)
    first = np.searchsorted(block_rows, np.arange(free + 1))
    lengths = (3 * np.diff(first)[:, None] - np.arange(3)).ravel()
    indptr = np.concatenate([[0], np.cumsum(lengths)])
    indices = np.empty(indptr[-1], np.int32)
    place = np.arange(len(pairs)) - first[block_rows]
    for r in range(3):
        start = indptr[3 * block_rows + r] + 3 * place - r
        for s in range(3):
            used = (place > 0) | (s >= r)
            indices[(start + s)[used]] = (3 * block_columns + s)[used]
    blocks, patch_blocks = (_places(own, pairs, first, free) for own in keys)
    held = lattice.held.ravel()
    crossed = np.repeat(held, np.diff(indptr)) | held[indices]
    return BlockPattern(
        size=3 * free,
        indptr=indptr.astype(np.int32),
        indices=indices,
        blocks=blocks,
        patch_blocks=patch_blocks,
        held=held,
        held_entries=np.flatnonzero(crossed).astype(np.int32),
    )


def _pair_keys(groups: Index, free: int) -> Index:
    """One number for each ordered pair of free nodes of a group, -1 for others, shape (groups, nodes, nodes)."""
    rows, columns = groups[:, :, None], groups[:, None, :]
    return np.where((rows <= columns) & (columns < free), rows * free + columns, -1)


def _places(keys: Index, pairs: Index, first: Index, free: int) -> Indices:
    """Place of each pair's block within its block row, -1 where there is none."""
    place = np.searchsorted(pairs, np.maximum(keys, 0)) - first[np.maximum(keys, 0) // free]
    return np.where(keys >= 0, place, -1).astype(np.int32)
