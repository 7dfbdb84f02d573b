"""Controllers by the name of their law, all made in one way.

``laws.NAME(arm, bandwidth=20.0, ...)`` gives a `Controller` for `simulate`, `compare` and a real
loop. Either give one ``bandwidth`` [rad/s], scalar or (n,), from which all gains follow by the rule
in the function's words, or each gain. All take the arguments of `Controller` too: limits of torque,
``hand_over``, ``velocity_filter``, ``bumpless``, ``delay``, and ``control_period``: where that is
given, a law that is too fast for it is refused.

Which one, by what you see (`steadyarm.recommended` is not of these: all its gains follow from a
rule, and it is the one to begin with where masses are known roughly):

- No mass matrix is known, motions are slow: `pd_gravity`.
- The model is good: `computed_torque`.
- An error stays that does not go away: `pid`, `momentum_observer` or `disturbance_observer`, in
  this order of what they need to know. Start here if you are in doubt.
- Only a rough inertia is known, velocities are quiet: `time_delay`.
- Loads change slowly, and what was learnt is to be read or kept: `slotine_li`,
  `natural_slotine_li` (chains of bodies), `adaptive_computed_torque`.
- What the model leaves out has no parameters: `passive_fuzzy`, `rbf_network`, or `computed_torque`
  with a `FuzzyCompensator`.
- A bound of what the model leaves out is known and noise is low: `sliding_mode`, `robust`,
  `super_twisting`, `rise`. They want an ``uncertainty``.
- The paper's feedback with the robust term that it leaves out: `h_infinity`.

An ``uncertainty`` is ``{"inertia": a, "acceleration": v, "disturbance": d}``: a bound a < 1 of
``|I - M⁻¹M₀|``, and bounds of the acceleration that the law asks for and of all else that is left
out, as an acceleration [rad/s²].

``s = de + slope e``. Symbols: e = q - q_d, M₀, C₀, G₀, H₀ of the nominal arm, τ_a the torque that
acted. Whatever integrates holds while the torque is limited.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Unpack

from numpy.typing import ArrayLike

from . import _core
from ._law import Common, compensator_settings, made

__all__ = [
    "adaptive_computed_torque",
    "computed_torque",
    "disturbance_observer",
    "h_infinity",
    "momentum_observer",
    "natural_slotine_li",
    "passive_fuzzy",
    "pd_gravity",
    "pid",
    "rbf_network",
    "rise",
    "robust",
    "sliding_mode",
    "slotine_li",
    "super_twisting",
    "time_delay",
]


def computed_torque(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    compensator: _core.FuzzyCompensator | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Computed torque, ``τ = M₀(ddq_d - K_v de - K_p e) + H₀``, with a compensator or without.

    ``bandwidth`` p: ``K_p = p²``, ``K_v = 2p``. Take it when the model is good. `ComputedTorque`
    is the same law with more to look at: weights, P, `design`.
    """
    settings = None if compensator is None else compensator_settings(compensator)
    return made(
        "computed_torque", arm, common, bandwidth=bandwidth, kp=kp, kv=kv, compensator=settings
    )


def pd_gravity(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
    damping: ArrayLike | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """PD with gravity, ``τ = G₀(q) - K_P e - K_D de``, gains in torque (Takegaki, Arimoto 1981).

    ``stiffness`` [N·m/rad], ``damping`` [N·m·s/rad]. ``bandwidth`` p: ``K_P = p²D``, ``K_D = 2pD``,
    D the mean of M₀'s diagonal over 24 poses. Take it where no mass matrix is known and motions
    are slow: it lags behind fast ones.
    """
    return made(
        "pd_gravity", arm, common, bandwidth=bandwidth, stiffness=stiffness, damping=damping
    )


def pid(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    ki: ArrayLike | None = None,
    uncertainty: Mapping[str, float] | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Computed torque with an integral, ``v = ddq_d - K_v de - K_p e - K_i ∫e``.

    ``bandwidth`` p: all three poles at -p, ``K_p = 3p²``, ``K_v = 3p``, ``K_i = p³``. Take it where
    an error stays: constant pushes, gravity that is off. With a constant M₀ it is computed torque
    with a disturbance observer.
    """
    gains = {"kp": kp, "kv": kv, "ki": ki}
    return made("pid", arm, common, bandwidth=bandwidth, **gains, uncertainty=uncertainty)


def sliding_mode(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    slope: ArrayLike | None = None,
    gain: ArrayLike | None = None,
    layer: ArrayLike | None = None,
    linear: ArrayLike | None = None,
    uncertainty: Mapping[str, float] | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Computed torque with variable structure (Slotine 1983; the paper's reference 2).

    ``v = ddq_d - slope de - gain sat(s/layer) - linear s``. ``bandwidth`` p, with an
    ``uncertainty``: slope and linear are p, gain what the uncertainty asks for and a tenth more,
    layer = gain/p. Take it where that is known and noise is low: it turns noise into torque.
    """
    gains = {"slope": slope, "gain": gain, "layer": layer, "linear": linear}
    return made("sliding_mode", arm, common, bandwidth=bandwidth, **gains, uncertainty=uncertainty)


def robust(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    q: float | None = None,
    bound: float | None = None,
    layer: float | None = None,
    gamma: float | None = None,
    uncertainty: Mapping[str, float] | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Robust computed torque (Corless, Leitmann 1981; Spong 1992).

    ``v = ddq_d - K_v de - K_p e - bound σ/max(|σ|, layer)``, ``σ = BᵀPx``, P of Lyapunov's equation
    with Q = q I, or of (19) with a ``gamma``. ``bandwidth`` p, with an ``uncertainty``:
    ``K_p = p²``, ``K_v = 2p``, bound what the uncertainty asks for and a tenth more, layer =
    bound/p. As `sliding_mode`, with a proof for all joints at once.
    """
    gains = {"kp": kp, "kv": kv, "q": q, "bound": bound, "layer": layer, "gamma": gamma}
    return made("robust", arm, common, bandwidth=bandwidth, **gains, uncertainty=uncertainty)


def h_infinity(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    q: float | None = None,
    gamma: float | None = None,
    r: float | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Nonlinear H∞ (Chen, Lee, Feng 1994): ``v = ddq_d - K_v de - K_p e - BᵀPx/r``.

    P of ``AᵀP + PA + q I - (2/r - γ⁻²)PBBᵀP = 0``: the robust term is the one that the paper leaves
    out. For ``r <= 2γ²`` there is a P for every q. ``bandwidth`` p: the rule of the law in Rust.
    """
    gains = {"kp": kp, "kv": kv, "q": q, "gamma": gamma, "r": r}
    return made("h_infinity", arm, common, bandwidth=bandwidth, **gains)


def super_twisting(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    slope: ArrayLike | None = None,
    k1: ArrayLike | None = None,
    k2: ArrayLike | None = None,
    uncertainty: Mapping[str, float] | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Super-twisting, ``v = ddq_d - slope de - k1 √|s| sgn s + w``, ``ẇ = -k2 sgn s``.

    Source: Levant 1993. s reaches 0 in finite time where the lumped acceleration changes by at
    most L: k1 > 1.5 √L, k2 > 1.1 L. ``bandwidth`` p, with an ``uncertainty``: slope p, L from what
    it asks for at up to p. Take it for pushes of bounded rate and low noise; it is the fastest
    after a change of mass.
    """
    gains = {"slope": slope, "k1": k1, "k2": k2}
    return made(
        "super_twisting", arm, common, bandwidth=bandwidth, **gains, uncertainty=uncertainty
    )


def rise(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    alpha1: ArrayLike | None = None,
    alpha2: ArrayLike | None = None,
    ks: ArrayLike | None = None,
    beta: ArrayLike | None = None,
    uncertainty: Mapping[str, float] | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Robust integral of the sign of the error (Xian and others 2004).

    ``e₂ = -(de + alpha1 e)``, ``v = ddq_d + (ks + 1)(e₂ - e₂(0)) + ∫[(ks + 1) alpha2 e₂ +
    beta sgn e₂]``. ``bandwidth`` p > 1, with an ``uncertainty``: alpha1 and alpha2 are p/2,
    ks + 1 = 3p. Take it for smooth pushes without noise.
    """
    gains = {"alpha1": alpha1, "alpha2": alpha2, "ks": ks, "beta": beta}
    return made("rise", arm, common, bandwidth=bandwidth, **gains, uncertainty=uncertainty)


def slotine_li(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    slope: ArrayLike | None = None,
    damping: ArrayLike | None = None,
    gain: float | None = None,
    speed: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Slotine and Li's law (1987): ``τ = Y(q, dq, v_r, a_r) θ - damping s``, ``θ̇ = -gain Yᵀs``.

    No inverse of M is needed, and the error goes to zero for any load that is a load. Friction that
    is not in the model is not learnt. ``bandwidth`` p: slope p, damping p D; gain from p and how
    the arm will move, ``speed`` [rad/s] (1) and ``acceleration`` [rad/s²] (3). Take it for loads
    that change slowly, and with a ``hand_over``: the gain from a bandwidth counts on errors that
    start small.
    """
    gains = {"slope": slope, "damping": damping, "gain": gain}
    motion = {"speed": speed, "acceleration": acceleration}
    return made("slotine_li", arm, common, bandwidth=bandwidth, **gains, **motion)


def natural_slotine_li(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    slope: ArrayLike | None = None,
    damping: ArrayLike | None = None,
    gain: float | None = None,
    speed: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """`slotine_li` with bodies that stay possible for ever (Lee, Kwon, Park 2018).

    The pseudo-inertia of every body moves by a congruence, so masses stay positive without a
    projection, and the steps depend on no units; ``gain`` [1/J]. For a `Serial` whose bodies have
    room in all directions. ``bandwidth`` as there.
    """
    gains = {"slope": slope, "damping": damping, "gain": gain}
    motion = {"speed": speed, "acceleration": acceleration}
    return made("natural_slotine_li", arm, common, bandwidth=bandwidth, **gains, **motion)


def passive_fuzzy(
    arm: _core.Arm,
    compensator: _core.FuzzyCompensator,
    *,
    bandwidth: ArrayLike | None = None,
    slope: ArrayLike | None = None,
    damping: ArrayLike | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """The passivity form of the fuzzy law, ``τ = M₀a_r + C₀v_r + G₀ - damping s - Wξ``.

    Source: Lewis 1996. ``Ẇ = gain s ξᵀ`` with basis, inputs, gain and modifications of
    ``compensator``; with a ``bandwidth`` p the gain follows from it: slope p, damping p D. Take it
    where what the model leaves out has no parameters; with the inputs "trajectory" or "state" it
    learns.
    """
    settings = compensator_settings(compensator)
    gains = {"slope": slope, "damping": damping}
    return made("passive_fuzzy", arm, common, bandwidth=bandwidth, **gains, compensator=settings)


def rbf_network(
    arm: _core.Arm,
    *,
    centers: Sequence[float],
    width: float,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    q: float | None = None,
    gain: float | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Computed torque with a network of radial basis functions (Feng 1995).

    ``ρ̂ = Wφ(x)``, ``φⱼ = exp(-|x - cⱼ|²/2 width²)`` over x = (e, de), ``Ẇ = gain BᵀPx φᵀ``, P of
    Lyapunov's equation with Q = q I. Near e = 0 it is an integrator: it does not learn the motion.
    ``bandwidth`` p: ``K_p = p²``, ``K_v = 2p``, and the gain with which s has its poles at -p/2.
    """
    gains = {"kp": kp, "kv": kv, "q": q, "gain": gain}
    network = {"centers": [float(center) for center in centers], "width": width}
    return made("rbf_network", arm, common, bandwidth=bandwidth, **gains, **network)


def adaptive_computed_torque(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    q: float | None = None,
    gain: float | None = None,
    cutoff: float | None = None,
    speed: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Computed torque whose model adapts (Craig, Hsu, Sastry 1987): the paper's reference 5.

    ``θ̇ = -gain Yᵀ M̂⁻¹ BᵀPx``, kept where M̂ > 0. It needs the acceleration, which it makes of
    velocities through a filter of ``cutoff`` [Hz]: with real sensors the error doubles. Sampled
    only. ``bandwidth`` p as for `slotine_li`.
    """
    gains = {"kp": kp, "kv": kv, "q": q, "gain": gain, "cutoff": cutoff}
    motion = {"speed": speed, "acceleration": acceleration}
    return made("adaptive_computed_torque", arm, common, bandwidth=bandwidth, **gains, **motion)


def time_delay(
    arm: _core.Arm,
    *,
    bandwidth: float | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    share: float | None = None,
    uncertainty: Mapping[str, float] | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Time-delay control (Youcef-Toumi, Ito 1990): what was left out last time is left out now.

    ``τ = τ_a + M̄(v - Δdq/h)`` with ``M̄ = share M₀``; nothing else of the model is used. Stable
    where ``|I - M⁻¹M̄| < 1``. Sampled only. With a ``bandwidth`` it needs ``control_period``. Take
    it where only a rough inertia is known and velocities are quiet: it turns noise into torque.
    """
    gains = {"kp": kp, "kv": kv, "share": share}
    return made("time_delay", arm, common, bandwidth=bandwidth, **gains, uncertainty=uncertainty)


def disturbance_observer(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    gain: ArrayLike | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Computed torque with a disturbance observer (Chen 2000; Mohammadi 2013).

    ``d̂ = z - gain dq``, ``ż = gain M₀⁻¹(τ_a - H₀ - d̂)``, gain [N·m·s/rad]. ``bandwidth`` p:
    ``K_p = p²``, ``K_v = 2p``, gain = p D. A good first addition to computed torque.
    """
    gains = {"kp": kp, "kv": kv, "gain": gain}
    return made("disturbance_observer", arm, common, bandwidth=bandwidth, **gains)


def momentum_observer(
    arm: _core.Arm,
    *,
    bandwidth: ArrayLike | None = None,
    kp: ArrayLike | None = None,
    kv: ArrayLike | None = None,
    pole: float | None = None,
    **common: Unpack[Common],
) -> _core.Controller:
    """Computed torque with a momentum observer (De Luca, Mattone 2003).

    ``r = pole (p̂ - M₀dq)``, ``p̂' = τ_a + C₀ᵀdq - G₀ - r``: what pushes, through
    ``1/(1 + s/pole)``, the same at every joint. ``bandwidth`` p: ``K_p = p²``, ``K_v = 2p``, pole
    the smallest p. A good first addition to computed torque, and no acceleration is needed.
    """
    gains = {"kp": kp, "kv": kv, "pole": pole}
    return made("momentum_observer", arm, common, bandwidth=bandwidth, **gains)
