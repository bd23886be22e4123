"""What the page says between its tables; numbers that the study computes stand in braces."""

OPENING = """
**Limits of this page.** Measured heatings with flow through the bed are on another page, [measured stores](measured-stores.md):
air through stones, and molten salt through quartzite. No measured heating time of a mold or of its wall is known to us, and the
thesis's figures are not available (its printed 1470 s for the aluminium mold is a computation). This page compares with
correlations, cited at second hand from programs and compilations (`studies/validation/correlations.py`) without their data
points, with five permeabilities, one pressure drop, and with beds without flow.

Re_d = rho U d/mu and Nu are on the bead diameter d and the superficial speed U, Re_m = Re_d/(1 - phi), phi is the void
fraction, D the tube's diameter. Two sets of closures are compared; a key that a scene sets wins:
"""
SETS = """
`measured` takes correlations of experiments where they exist. Not measured are its decaying turbulence (`docs/theory.md`) and
how heat passes the wall between rest and Re_d = 40 (`porousmold/laws/conductivity.py`).
"""
PRESSURE = """
dp/L = F (1 - phi)/phi^3 rho U^2/d. Developed flow of air, laminar with the closures `thesis` (turbulence adds 1 to 2 %) and
as it comes with `measured`; F of the model over that of the correlation, both at the model's mean void fraction. Tubes of D/d
10, 20, 30, and slabs of 2 H/d 20, 30 (that a gap counts as twice its width is an assumption without a source). **`measured`
takes the KTA law**, which Erdim's and Carman's resemble: these rows test how a law of the bulk works with a porosity that
varies towards the wall, not the law. KTA states void fractions of 0.36 to 0.42, which the beds of D/d = 10 exceed; Erdim's
and Dixon's ranges end before the fastest flows and the widest beds.
"""
PRESSURE_AT_MEASURED_VOID = """
An experiment has the mean void that it has. Pressure drop of the model over the median of the six correlations at Dixon's
mean void, Re_d 100 to 1000:
"""
PRESSURE_END = """
The thesis's inertial constant does not fall with the Reynolds number; laws fitted to spheres fall about as Re^-0.1. At D/d =
10 the porosity of `measured` leaves the channel at the wall too wide.
"""
VOID_END = """
The fit of Giese, Rottschaefer and Vortmeyer (1998) to their laser-Doppler measurements gives 32 to 35 % within d/2 at D/d =
10. The mean error of Benyahia and O'Neill's correlation is 1.5 %, that of Dixon's is not given.
"""
HEAT = """
Overall coefficient h between wall and mixed mean, far from the inlet, Nu = h d/lambda_f, of ceramic beads of 5 mm (2.09
W/m/K) in air at 300 K; tubes of D/d 10, 15, 20, 30. Eight correlation sets:
"""
SET_RANGES = """\
| set | what it gives | valid |
|---|---|---|
| Leva 1947 | overall | Re_d 250 to 3000, D/d 3.3 to 20 |
| Li, Finlayson 1977 | overall | Re_d 20 to 7600, D/d 3.3 to 20 |
| VDI Heat Atlas M7: Schluender's k_r, Nu_w of Martin and Nilles 1993 | k_r and Nu_w | Re_d 35 to 500 as compiled, D/d 3.3 to 20 |
| k_r of Specchia 1980, Nu_w of Yagi and Wakao 1959 | k_r and Nu_w | Re_d 20 to 2000, D/d 6 to 47 |
| the same, Nu_w of Li and Finlayson 1977 | k_r and Nu_w | Re_d 20 to 7600, D/d 3.3 to 20 |
| the same, Nu_w of Colledge and Paterson 1984 | k_r and Nu_w | not given |
| the same, Nu_w of Dixon, DiCostanzo and Soucy 1984 | k_r and Nu_w | Re_d 50 to 500, D/d 3 to 12 |
| Winterberg, Tsotsas 2000 | profile of conductivity, one temperature | Pe up to 1e4, D/d from 4 |
"""
SCATTER = """
They lie {rms:.0%} (rms) from their median over all 32 points, {near:.0%} at Re_d 420 to 1000; extremes {low:.2f} and
{high:.2f}. Some are used beyond their range.

**`measured` is not independent of these sets.** It takes the dispersion of Winterberg and Tsotsas and the bed at rest that
six of the eight use, and how both are combined with eddies and ended at the wall was chosen to agree with them. Its row shows
that one model holds over the whole range. Independent of it are Leva, and Li and Finlayson, who have a column of their own.

Nu of the model over the median of the eight:
"""
BRANCHES = """
Plain k-epsilon has two steady solutions between Re_d 420 and 2000, laminar and turbulent. Which one the solver converges to
depends on its initial guess, so this row is not a prediction. N-K are the bead sources of Nakayama and Kuwahara; "damped":
they fade out below a bead Reynolds number of 800 to 900 on the interstitial speed.
"""
SPLIT = """
k_r/lambda_f in the middle of the tube, and the Nu_w that gives the overall coefficient with it in plug flow: b J1(b) = Bi
J0(b), Bi = Nu_w D/(2 k_r d), Nu = k_r b^2 d/D with k_r over lambda_f; D/d = 20. Published Nu_w: Yagi and Wakao, Li and
Finlayson, Colledge and Paterson, Dixon et al., to go with Specchia's k_r.
"""
SPLIT_END = """
**Reason for the thesis's numbers.** At Re_d about 400, that of its mold, the overall coefficient agrees with the correlations
because two errors compensate: the bead conduction is five times the measured stagnant conductivity, and there is no dispersion
across the flow except by eddies. At other Reynolds numbers they do not compensate: at Re_d = 3000 a laminar flow transfers a
fifth of the correlated heat, at Re_d = 100 wide tubes transfer one and a half times as much.

The coefficients are those of a section of the program's own developed flow. Two runs of its energy equation, beds of
{short:g} and {long:g} m at Re_d = 420, D/d = 10, give the same Nu: {told}.
"""
PERMEABILITY = """
The thesis measured five beds by falling heads (tables 4.3 to 4.5; global evaluation). Predictions, as it prints them with its
unrounded porosities, over measurements:
"""
PERMEABILITY_END = """
The five beds give {mean:.0f} ± {deviation:.0f} (one sigma, without the error of the porosity: 0.01 moves a permeability by 11
%): Macdonald's 180 rather than Ergun's 150, and rather than the 160 of KTA that `measured` takes. Nothing measured there
tests the inertial constant.
"""
AT_REST = """
Effective conductivities and a profile in vacuum that we hold as numbers (`studies/validation/data/`, with where they come from),
beside the law of Zehner, Bauer and Schluender that `measured` takes for a bed at rest; its published scatter is ±30 %. No
void fraction stands beside any point, so each is computed for the beds that it can have been.
"""
AT_REST_END = """
- **Li2TiO3** in helium, where contacts do not matter, agrees within 15 %, with the measured slope against temperature.
- **COMET's graphite** of 1 mm conducts less than half of the law: its grains are rough, and contact is worse than that of two
  smooth spheres, which the law assumes. Its gas pressure is not stated.
- **SANA's pebbles** of 60 mm conduct twice the law, most in cold nitrogen, 4 to 6 times, where the measured value *falls*
  with temperature: natural convection in voids of centimetres is in these values. The law has no term for it, nor has this
  program: large pebbles at rest in a dense gas conduct more than it says.
"""
COMPILATION = """
Twenty-five values of many authors, van Antwerpen's compilation: conductivity of the bed over that of its gas. Two values
at the same ratio of 2360 differ by a factor of 3.4: smooth and rough, hard and soft beads. A law without
roughness cannot be nearer than that.
"""
VACUUM = """
Graphite pebbles of 60 mm in vacuum between walls of 800 and 163 °C (De Beer 2014), 7 points between the outermost
thermocouples, range 458 K: the shape of the profile tests how the conductivity grows with temperature. The measured slopes
give 2.07 for the ratio of the conductivities at 770 and 453 °C. Radiation alone (flattening 0) grows too steeply.
"""
HELIUM = """
Helium through steel beads of 1 mm in a tube of 28 mm, 20 °C (Cheng et al. 2024): slope from 0.15 to 0.55 m, at 0.5 and 1.0 m/s
(Re_d 4 to 17). The pressure of the gas is given as 0.1 to 0.2 MPa, which is worth 8 to 14 %.
"""
STEEL = """
`studies/beds/steel_heated_from_above.toml`: air at rest, the wall put from 20 to 53 °C; thermocouples 40, 60 and 73 mm below
it (C. Beaulieu, PhD thesis, Polytechnique Montreal 2020, digitised by the Lethe project, whose further curves put the
experiment's own band at about ±2 K).
"""
STEEL_END = """
The model stays below the curves: `measured` has {rises} of the measured rise at 4000 s. At 73 mm both sets are as far off:
that depth does not tell them apart. The emissivity of these beads was not measured; 0.3 stands for clean stainless steel.
Zehner, Bauer and Schluender give 0.45 W/m/K without radiation, the curves themselves 0.56; their published scatter is ±30 %.
As published heat reaches the beads only by convection.
"""
TIMES = """
Until the wall is within 2 K of the inlet, in s; developed flow. Re_d and D/d are 398 and 20 (2 H/d) in the molds, 259 and 20 in
the pipe. The sets' own turbulence is damped N-K (`thesis`) and decaying N-K (`measured`).
"""
TIMES_LATERAL = """
`lateral`: conduction and dispersion of `measured` alone, across the flow only, with drag, turbulence and porosity of `thesis`;
`lateral and axial` adds dispersion along the flow (Pe/2).

**Axial dispersion is part of `measured`**, since Wakao's exchange was evaluated with it: without it the exchange is too large and
the front of the [measured store of stones](measured-stores.md) too steep (19.0 K rms in place of 13.5; of the quartzite in salt
it changes nothing, whose front is broad from the start). It adds some 1 % to the heating times here, nothing to the overall
coefficients above, which are those of a section far from the inlet, and nothing to the bed of steel beads at rest. Radiation
(`bed.emissivity`) is a property of the beads and not of the set: a scene whose beads would radiate more than 20 % of what the bed
conducts is warned of.
"""
TIMES_END = """
The published 1470 s (aluminium) and 1275 s (FRP) are nearer to `measured`; both sides are computed, and the thesis prints
Macdonald's drag: a coincidence, no evidence.

Aluminium beads in the aluminium mold: `thesis` {slow:.0f} s, `measured` {fast:.0f} s. As published, conduction along the
beads (0.6 x 237 W/m/K) spreads the thermal front; the run warns.
"""


def paragraphs(text: str, **numbers: object) -> list[str]:
    """Lines for a page: each paragraph one line, an empty one after it."""
    joined = (" ".join(part.split()) for part in text.format(**numbers).split("\n\n"))
    return [line for paragraph in joined for line in (paragraph, "")]
