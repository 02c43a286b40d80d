import numpy as np
import pytest

from oed.design.optimisers.binary_coding import BinaryCoding

Q_MAX, W, OMEGA_MAX = 1.5, 3, np.sqrt(5 / 1.5)


def paper_coding() -> BinaryCoding:
    """Two joints, W = 3, n_a = n_omega = 4: the genotype of 48 bits of section 5."""
    amplitude, frequency = [[-Q_MAX / W, Q_MAX / W]] * 6, [[0.0, OMEGA_MAX]] * 6
    return BinaryCoding(np.array(amplitude + frequency), np.full(12, 4))


def genotype(integers: list[int], bits: int = 4) -> np.ndarray:
    return np.array([bit == "1" for value in integers for bit in f"{value:0{bits}b}"])


def test_the_papers_genotype_has_48_bits() -> None:
    assert paper_coding().length == 48


def test_decodes_by_hand_as_equations_13_and_14() -> None:
    integers = [0, 15, 7, 8, 3, 12, 0, 15, 1, 2, 14, 9]
    z = paper_coding().decode(genotype(integers))
    a_max = Q_MAX / W
    by_hand = [(2 * A / 15 - 1) * a_max for A in integers[:6]]
    by_hand += [omega / 15 * OMEGA_MAX for omega in integers[6:]]
    np.testing.assert_allclose(z, by_hand, rtol=1e-15, atol=1e-16)


def test_the_first_bit_of_a_gene_weighs_most() -> None:
    coding = BinaryCoding(np.array([[0.0, 15.0]]), np.array([4]))
    assert coding.decode(np.array([True, False, False, False])) == pytest.approx([8.0])


def test_genes_may_differ_in_length() -> None:
    coding = BinaryCoding(np.array([[0.0, 3.0], [0.0, 1.0]]), np.array([2, 1]))
    np.testing.assert_array_equal(coding.decode(np.array([True, False, True])), [2.0, 1.0])


def test_every_genotype_is_in_the_box() -> None:
    coding = paper_coding()
    z = coding.decode(coding.random(500, np.random.default_rng(0)))
    assert (z >= coding.bounds[:, 0]).all()
    assert (z <= coding.bounds[:, 1] * (1 + 1e-15)).all()


def test_refuses_an_infinite_box_and_an_empty_gene() -> None:
    with pytest.raises(ValueError, match="finite"):
        BinaryCoding(np.array([[0.0, np.inf]]), np.array([4]))
    with pytest.raises(ValueError, match="bits"):
        BinaryCoding(np.array([[0.0, 1.0]]), np.array([0]))
    with pytest.raises(ValueError, match="2 genes for 1"):
        BinaryCoding(np.array([[0.0, 1.0]]), np.array([4, 4]))
