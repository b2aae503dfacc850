"""A translucent sensor fitted to one real press: constants, renderings, a model of their rings, comparisons."""
