"""The printed block as springs: cells, walls, planes, energy and rate dependence."""
