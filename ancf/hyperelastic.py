r"""Neo-Hookean and Mooney-Rivlin rubber.

    neo-Hookean     Psi = mu/2 (I_1 - 3 - 2 ln J) + lambda/2 (ln J)^2
    Mooney-Rivlin   Psi = c10 (J^(-2/3) I_1 - 3) + c01 (J^(-4/3) I_2 - 3) + K/2 (J - 1)^2

Each is the sum of a shape part and a volume part (potentials.py), because elements integrate the two by
different rules (section_energy.py).
"""

from __future__ import annotations

from dataclasses import dataclass

from ancf.materials import SaintVenantKirchhoff
from ancf.potentials import (
    Difference,
    LogarithmicVolume,
    MooneyRivlinShape,
    NeoHookeanShape,
    OfVolume,
    Potential,
    QuadraticPotential,
    QuadraticVolume,
    Total,
    VolumeEnergy,
)


@dataclass(frozen=True)
class NeoHookean:
    """Compressible neo-Hookean rubber; Young's modulus [Pa], Poisson ratio [-], density [kg/m3] or None.

    A good rubber up to stretches of about 1.5; needs det F > 0.
    """

    young_modulus: float
    poisson_ratio: float
    density: float | None = None

    @property
    def lame_mu(self) -> float:
        """Shear modulus at small strain, E / (2 (1 + nu)) [Pa]."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        """First Lame constant at small strain, E nu / ((1 + nu)(1 - 2 nu)) [Pa]."""
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    @property
    def shape(self) -> Potential:
        """The law without its volume part."""
        return NeoHookeanShape(self.lame_mu)

    @property
    def volume(self) -> VolumeEnergy:
        """The volume part."""
        return LogarithmicVolume(self.lame_lambda)


@dataclass(frozen=True)
class MooneyRivlin:
    """Mooney-Rivlin rubber; c10, c01, bulk modulus K [Pa], density [kg/m3] or None.

    mu = 2 (c10 + c01), E = 9 K mu/(3 K + mu), nu = (3 K - 2 mu)/(2 (3 K + mu)) at small strain. Needs det F
    > 0; with c01 < 0 the law may lose stability at moderate stretch.
    """

    c10: float
    c01: float
    bulk_modulus: float
    density: float | None = None

    @property
    def lame_mu(self) -> float:
        """Shear modulus at small strain [Pa]."""
        return 2.0 * (self.c10 + self.c01)

    @property
    def lame_lambda(self) -> float:
        """First Lame constant at small strain, K - 2 mu / 3 [Pa]."""
        return self.bulk_modulus - 2.0 / 3.0 * self.lame_mu

    @property
    def young_modulus(self) -> float:
        """Young's modulus at small strain [Pa]."""
        mu, K = self.lame_mu, self.bulk_modulus
        return 9.0 * K * mu / (3.0 * K + mu)

    @property
    def poisson_ratio(self) -> float:
        """Poisson ratio at small strain [-]."""
        mu, K = self.lame_mu, self.bulk_modulus
        return (3.0 * K - 2.0 * mu) / (2.0 * (3.0 * K + mu))

    @property
    def shape(self) -> Potential:
        """The law without its volume part."""
        return MooneyRivlinShape(self.c10, self.c01)

    @property
    def volume(self) -> VolumeEnergy:
        """The volume part."""
        return QuadraticVolume(self.bulk_modulus)


Rubber = NeoHookean | MooneyRivlin
Law = SaintVenantKirchhoff | NeoHookean | MooneyRivlin


def enhanced_potentials(law: Rubber, shear_factors: tuple[float, float]) -> tuple[Potential, Potential]:
    """Split Psi = Psi_0 + (Psi - Psi_0): Psi_0 for the section, the rest for the axis only.

    Psi_0 is the same rubber with the same Young's modulus E and Poisson ratio 0, its shear moduli E/2
    brought to G k by a quadratic term: at small strain diag(E, E, E, G, k_z G, k_y G), as in
    `SaintVenantKirchhoff.enhanced`. Uniform states obey the full law exactly (at k = 1), and bending has E I
    at every Poisson ratio, because a linear section need not show the in-plane field that Psi demands.

    Strains belong in the section's own axes.
    """
    young, mu = law.young_modulus, law.lame_mu

    def lateral_free(k_y: float, k_z: float) -> Potential:
        extra = (0.0, 0.0, 0.0, mu - 0.5 * young, k_z * mu - 0.5 * young, k_y * mu - 0.5 * young)
        rows = tuple(tuple(extra[i] if i == j else 0.0 for j in range(6)) for i in range(6))
        return Total((*_without_contraction(law), QuadraticPotential(rows)))

    return lateral_free(*shear_factors), Difference(full_potential(law), lateral_free(1.0, 1.0))


def _without_contraction(law: Rubber) -> tuple[Potential, ...]:
    """The parts of the same rubber with the same Young's modulus and Poisson ratio 0."""
    young = law.young_modulus
    if isinstance(law, NeoHookean):
        return (NeoHookeanShape(0.5 * young),)
    share = 0.5 * young / law.lame_mu
    return MooneyRivlinShape(share * law.c10, share * law.c01), OfVolume(QuadraticVolume(young / 3.0))


def full_potential(law: Rubber) -> Potential:
    """The whole law."""
    return Total((law.shape, OfVolume(law.volume)))
