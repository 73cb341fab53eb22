"""Linear systems of Markov chains that are too large to be factored: Gauss-Seidel iteration."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from ltlc.mdp.explicit import FloatArray, IntArray


class GaussSeidel:
    """Solves v = gain + matrix v by sweeps over the states in a given order.

    A sweep uses what it has just found for earlier states, so that states should come after those they lead to. Each
    sweep is a sparse triangular solve, whose factor is no larger than the matrix. From a value below the solution it
    rises to it, and never slower than by plain steps.

    References:
        R. Varga, Matrix Iterative Analysis, 2nd ed., Springer 2000, section 3.3 (Stein-Rosenberg theorem),
        DOI 10.1007/978-3-642-05156-2.
    """

    def __init__(self, matrix: Any, order: IntArray) -> None:
        place = np.empty(len(order), dtype=np.int32)
        place[order] = np.arange(len(order), dtype=np.int32)
        rows = matrix[order]
        permuted = sparse.csr_array((rows.data, place[rows.indices], rows.indptr), shape=rows.shape)
        earlier = sparse.eye_array(len(order), format="csc") - sparse.tril(permuted, format="csc")
        self._later = sparse.triu(permuted, 1, format="csr")
        self._order = order
        self._solve = splu(
            earlier.tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        ).solve

    def run(self, gain: FloatArray, value: FloatArray, tolerance: float, most: int) -> tuple[FloatArray, bool]:
        """At most `most` sweeps from `value`, until one changes nothing by more than `tolerance`; whether it came to.

        Shapes (n_states,).
        """
        here, right = value[self._order], gain[self._order]
        converged = False
        for _ in range(most):
            update = np.asarray(self._solve(right + self._later @ here))
            converged = bool(np.abs(update - here).max(initial=0.0) <= tolerance)
            here = update
            if converged:
                break
        result = np.empty_like(here)
        result[self._order] = here
        return result, converged
