import numpy as np, csv, sys
from scipy.special import ive

rows = list(csv.reader(open(sys.argv[1] if len(sys.argv) > 1 else "run/history.csv")))
H = rows[0]
A = np.array(rows[1:], float)
t = A[:, 0]
out = A[:, H.index("outlet_temperature [K]")]
mid = A[:, H.index("temperature_centre_L/2 [K]")]
G = 0.01 / (np.pi * 0.09 / 4)
cp = 1005
L = 1
d = 0.02
Re = G * d / 3e-5
Pr = 3e-5 * cp / 0.04
Nu = 2 + 1.1 * Re**0.6 * Pr ** (1 / 3)
h = Nu * 0.04 / d
av = 6 * 0.6 / d


def schumann(x, t):
    # fluid temperature theta_f: xi = h av x/(G cp), eta = h av (t - x/u)/((1-phi) rho_s c_s)
    xi = h * av * x / (G * cp)
    eta = h * av * (t - x * 0.4 * 1.0 / G) / (0.6 * 5000 * 800)
    if eta <= 0:
        return 0.0
    # theta_f = 1 - exp(-eta) * int_0^xi exp(-s) I0(2 sqrt(s eta)) ds
    s = np.linspace(0, np.sqrt(xi), 20001) ** 2
    z = 2 * np.sqrt(s * eta)
    f = np.exp(-((np.sqrt(s) - np.sqrt(eta)) ** 2)) * ive(0, z)
    return 1 - np.trapz(f, s)


print("NTU", h * av * L / (G * cp), "h", h)
e = []
for k in range(0, len(t), 3):
    a = 298.15 + 475 * schumann(1, t[k])
    b = 298.15 + 475 * schumann(0.5, t[k])
    e.append((out[k] - a, mid[k] - b))
    print(
        "%8.0f out %.1f exact %.1f (%+.1f)   mid %.1f exact %.1f (%+.1f)"
        % (t[k], out[k], a, out[k] - a, mid[k], b, mid[k] - b)
    )
print(np.abs(e).max(0))
