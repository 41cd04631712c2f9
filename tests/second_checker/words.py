"""Every word that a certificate says: the statements and the labels of inequalities that hold a number or a name."""

from fractions import Fraction


def digits_of(x):
    """The shortest decimal digits that read back as this binary64 number, and the exponent of the first."""
    mantissa, _, exponent = f"{float(abs(x))!r}".partition("e")
    whole, _, part = mantissa.partition(".")
    part = "" if part == "0" else part
    digits = (whole + part).lstrip("0")
    first = len(whole) - 1 if whole.strip("0") else -1 - (len(part) - len(part.lstrip("0")))
    return digits.rstrip("0") or "0", first + int(exponent or 0) if digits else 0


def decimal(x):
    """The shortest decimal, with an exponent where the magnitude asks for one."""
    digits, first = digits_of(x)
    if x and not Fraction(1e-4) <= abs(x) < 10**7:
        text = digits[0] + ("." + digits[1:] if digits[1:] else "") + f"e{first}"
    elif first < 0:
        text = "0." + "0" * (-1 - first) + digits
    else:
        digits = digits.ljust(first + 1, "0")
        text = digits[: first + 1] + ("." + digits[first + 1 :] if digits[first + 1 :] else "")
    return "-" * (x < 0) + text


def exact(x):
    """The number itself: a decimal where the shortest one is exactly the number, else hexadecimal with that decimal
    beside it.
    """
    near = decimal(x)
    return near if Fraction(near) == x else f"{hexadecimal(x)} (about {near})"


def rounded(x, digits, up):
    """A positive number as a decimal of so many digits, rounded down or up."""
    first = 0
    while Fraction(10) ** (first + 1) <= x:
        first += 1
    while Fraction(10) ** first > x:
        first -= 1
    scaled = x / Fraction(10) ** (first - digits + 1)
    kept = -(-scaled.numerator // scaled.denominator) if up else scaled.numerator // scaled.denominator
    text = str(kept)
    first += len(text) - digits
    text = text.rstrip("0")
    if not -4 <= first <= 6:
        return text[0] + ("." + text[1:] if text[1:] else "") + f"e{first}"
    if first < 0:
        return "0." + "0" * (-first - 1) + text
    text = text.ljust(first + 1, "0")
    return text[: first + 1] + ("." + text[first + 1 :] if text[first + 1 :] else "")


def at_least(x, digits):
    return rounded(x, digits, False) if x else "0"


def at_most(x, digits):
    return rounded(x, digits, True) if x else "0"


# Characters that leave no mark of their own, or move others: the first and the last of each range.
INVISIBLE = (
    (0x0000, 0x001F),
    (0x007F, 0x00A0),
    (0x00AD, 0x00AD),
    (0x034F, 0x034F),
    (0x0600, 0x0605),
    (0x061C, 0x061C),
    (0x06DD, 0x06DD),
    (0x070F, 0x070F),
    (0x0890, 0x0891),
    (0x08E2, 0x08E2),
    (0x115F, 0x1160),
    (0x1680, 0x1680),
    (0x17B4, 0x17B5),
    (0x180B, 0x180F),
    (0x2000, 0x200F),
    (0x2028, 0x202F),
    (0x205F, 0x206F),
    (0x2800, 0x2800),
    (0x3000, 0x3000),
    (0x3164, 0x3164),
    (0xFE00, 0xFE0F),
    (0xFEFF, 0xFEFF),
    (0xFFA0, 0xFFA0),
    (0xFFF0, 0xFFFB),
    (0x110BD, 0x110BD),
    (0x110CD, 0x110CD),
    (0x13430, 0x1345F),
    (0x1BCA0, 0x1BCA3),
    (0x1D173, 0x1D17A),
    (0xE0000, 0xE0FFF),
)


def visible(text):
    """The text with `\\u{200b}` and so on in place of invisible characters."""
    return "".join(
        f"\\u{{{ord(c):x}}}" if any(first <= ord(c) <= last for first, last in INVISIBLE) else c for c in text
    )


def quoted(name):
    return '"' + visible(name.replace("\\", "\\\\").replace('"', '\\"')) + '"'


def hexadecimal(x):
    """The shortest hexadecimal float of a binary64 number, with the leading digit 1."""
    if x == 0:
        return "0x0p0"
    n = abs(x).numerator
    top = n.bit_length() - x.denominator.bit_length()
    n >>= (n & -n).bit_length() - 1
    width = -(-(n.bit_length() - 1) // 4)
    part = (n << (4 * width - n.bit_length() + 1)) - (1 << (4 * width))
    return "-" * (x < 0) + "0x1" + (f".{part:0{width}x}" if width else "") + f"p{top}"


def counted(count, noun, many=None):
    return f"{count} {noun}" if count == 1 else f"{count} {many or noun + 's'}"


def sizes(states, inputs, outputs):
    return f"{counted(states, 'state')}, {counted(inputs, 'input')} and {counted(outputs, 'output')}"


def rate_term(rate, p):
    return f" + 2 rate {p}" if rate else ""


def enclosed(is_single, symmetric=""):
    if is_single:
        return ""
    symmetric = f" that makes {symmetric} symmetric" if symmetric else ""
    return (
        " Entries given by two bounds, and fractions that binary64 does not have, stand for all numbers between: "
        f"the statement holds for every choice of them{symmetric}."
    )


def decay(rate, function="e'Pe", variable="e"):
    """What a Lyapunov function says of its argument."""
    if not rate:
        return f"V = {function} decreases and {variable} tends to 0 exponentially"
    return (
        f"V = {function} satisfies V(t) <= exp(-2 rate t) V(0) with rate = {exact(rate)}, "
        f"so that {variable} tends to 0 at least like exp(-rate t)"
    )


def linear_observer(states, inputs, outputs, rate, is_single):
    return (
        f"For the plant x' = Ax + Bu, y = Cx with {sizes(states, inputs, outputs)} and the observer xhat' = A xhat + "
        "Bu + L(y - C xhat), "
        f"the error e = x - xhat obeys e' = (A - LC)e, and {decay(rate)}, from every e(0).{enclosed(is_single)}"
    )


def discrete_observer(states, inputs, outputs):
    return (
        f"For the discrete-time plant x+ = Ax + Bu, y = Cx with {sizes(states, inputs, outputs)} and the observer "
        "xhat+ = A xhat + Bu + L(y - C xhat), "
        "the error e = x - xhat obeys e+ = (A - LC)e, V = e'Pe decreases at each step, and e tends to 0 exponentially, "
        "from every e(0)."
    )


def hurwitz(n, is_single):
    if is_single:
        return (
            f"All eigenvalues of the {n} x {n} matrix A have negative real parts: "
            "every solution of x' = Ax tends to 0 exponentially."
        )
    return (
        f"Every solution of x' = A(t)x with {n} states tends to 0 exponentially, however A(t) varies in its bounds; "
        f"in particular all eigenvalues of every such A have negative real parts.{enclosed(is_single)}"
    )


def schur(n):
    return (
        f"All eigenvalues of the {n} x {n} matrix A lie inside the unit circle: "
        "every solution of x+ = Ax tends to 0 exponentially."
    )


CUBIC = "the cubic observer xhat' = A xhat + Bu + L r - (r'theta r) N r, r = y - C xhat"
CUBIC_ERROR = "the error e = x - xhat obeys e' = (A - LC)e + (e'C'theta C e) N C e"


def region(level):
    return "from every e(0)" if level is None else f"from every e(0) with e(0)'P e(0) < {exact(level)}"


def cubic_observer(size, rate, level, *_):
    return (
        f"For the plant x' = Ax + Bu, y = Cx with {sizes(*size)} and {CUBIC}, {CUBIC_ERROR}. With the gains L and N "
        "exactly as stored, e tends to 0 exponentially, "
        f"{region(level)}. With the real matrix -P^-1 C'S in place of N, {decay(rate)}, from every e(0)."
    )


def structured_cubic_observer(states, inputs, outputs, rate):
    return (
        f"For the plant x' = Ax + Bu, y = Cx with {sizes(states, inputs, outputs)} and {CUBIC}, with the real gain N = "
        f"-P^-1 C'S: {CUBIC_ERROR}, "
        f"and {decay(rate)}, from every e(0). Nothing is said of a rounding of N."
    )


def cubic_theorem_1(states, inputs, outputs):
    return (
        f"For the plant x' = Ax + Bu, y = Cx with {sizes(states, inputs, outputs)} and {CUBIC}, with L and N exactly "
        f"as stored: {CUBIC_ERROR}, "
        f"and {decay(0)}, from every e(0)."
    )


def sampled_cubic_observer(states, inputs, outputs, w, period):
    return (
        f"For the sampled plant x+ = Ax + Bu, y = Cx with {sizes(states, inputs, outputs)} and the sampled cubic "
        "observer xhat+ = A(xhat - g N z) + Bu + r L z, z = y - C xhat, "
        f"q = max(z'theta z, 0), r = 1/sqrt(1 + 2 w h q), g = (1 - r)/w, with w = {exact(w)} and the period h = "
        f"{exact(period)} and all numbers as given, in exact arithmetic: "
        "the error e = x - xhat obeys e+ = (A - LC + g (AN + wL)C)e with 0 <= g < 1/w, V = e'Pe falls at each step by "
        "a factor below 1, and e tends to 0 exponentially, from every e(0). "
        "Nothing is said of the rounding of its steps."
    )


def semi_implicit_cubic_observer(states, inputs, outputs, period):
    return (
        f"For the sampled plant x+ = Ax + Bu, y = Cx with {sizes(states, inputs, outputs)} and the semi-implicit "
        "sampled cubic observer xhat+ = A(xhat - s N r) + Bu + L r, (I - s C N) r = z, z = y - C xhat, "
        f"s = h max(z'theta z, 0), with the period h = {exact(period)} and all numbers as given, in exact arithmetic: "
        "I - s C N is invertible, the error e = x - xhat obeys e+ = (A - LC)d with (I - s N C)d = e, V = e'Pe falls at "
        "each step by a factor below 1, and e tends to 0 exponentially, from every e(0). "
        "The same holds with any other s >= 0 at each step. Nothing is said of the rounding of its steps."
    )


CORRECTIONS = {
    "linear": ("xhat+ = xhat + K z, z = y - C xhat", "e+ = exp(At)(I - KC)e", "factor^2"),
    "radial": (
        "xhat+ = xhat - g N z + r K z, z = y - C xhat, r = 1/sqrt(1 + 2 w T max(z'theta z, 0)), g = (1 - r)/w, "
        "with w = {w} and any T >= 0",
        "e+ = exp(At)(I + g N C - r K C)e with 0 <= g < 1/w",
        "factor^2",
    ),
    "semi-implicit": (
        "xhat+ = xhat - s N r + K r, (I - s C N) r = z, z = y - C xhat, s = T max(z'theta z, 0), with any T >= 0",
        "e+ = exp(At)(I - KC)d with (I - s N C)d = e",
        "2 factor^2/(1 + factor^2)",
    ),
}


def varying_periods(size, step, w, shortest, longest, misses, factor):
    correction, errors, falls = CORRECTIONS[step]
    if w is not None:
        correction = correction.replace("{w}", exact(w))
    if misses:
        missed = f"of which at most {misses} in a row {'is' if misses == 1 else 'are'} missed"
    else:
        missed = "of which none is missed"
    return (
        f"For the plant x' = Ax + Bu, y = Cx with {sizes(*size)}, sampled at periods from {exact(shortest)} to "
        f"{exact(longest)}, each of any length between, {missed}, and the observer that predicts by xhat' = A xhat + "
        f"Bu and corrects at each sample that is not missed by {correction}, with all numbers as given, in exact "
        f"arithmetic: the error e = x - xhat before a correction obeys {errors}, t being the time to the next "
        f"correction, V = e'Pe is before the next correction at most {falls} times what it is before this one, with "
        f"factor = {exact(factor)}, and e tends to 0 exponentially, from every e(0). Nothing is said of the rounding of "
        "its steps."
    )


def feedback_loop(size, rate, level):
    return (
        f"{cubic_observer(size, rate, level)} In the loop u = -K xhat, x and e tend to 0 exponentially from every "
        f"x(0), with the gains K, L and N exactly as stored {region(level)}; "
        "with the real matrix -P^-1 C'S in place of N, x'P1x + e'Pe decreases, from every e(0)."
    )


def hull(count, states, outputs, is_single):
    if is_single:
        what = "pair (A, C)" if count == 1 else "pairs (A_k, C_k)"
    else:
        what = "box of pairs (A, C)" if count == 1 else "boxes of pairs (A_k, C_k)"
    return f"the convex hull of the {count} {what} with {counted(states, 'state')} and {counted(outputs, 'output')}"


def polytope_of_plants(count, states, outputs, rate, is_single):
    return (
        "For every plant x' = A(t)x + Bu, y = C(t)x whose pair (A(t), C(t)) lies in "
        f"{hull(count, states, outputs, is_single)} "
        "at all times, "
        f"and every solution of e' = (A(t) - L C(t))e, {decay(rate)}. This e is the error of the observer with the "
        "same A(t) and C(t) and the gain L; "
        "the forcing (A(t) - A)x of an observer that runs another A is not covered."
    )


def polytope_of_jacobians(count, states, outputs, rate, is_single):
    return (
        f"For all matrices (A(t), C(t)) in {hull(count, states, outputs, is_single)}, and every solution of e' = (A(t) "
        f"- L C(t))e, {decay(rate)}. "
        "Hence for a plant x' = f(t, x, u), y = h(t, x) and the observer xhat' = f(t, xhat, u) + L(y - h(t, xhat)), as "
        "long as the mean Jacobians of f and h between xhat and x lie "
        "in this hull: that they do is a hypothesis, of which this certificate says nothing."
    )


def discrete_polytope_of_jacobians(count, states, outputs, factor, is_single):
    if factor == 1:
        falls = "V = e'Pe falls at each step by a factor below 1, and e tends to 0 exponentially"
    else:
        falls = (
            f"V = e'Pe satisfies V(k) <= factor^(2k) V(0) with factor = {exact(factor)}, "
            "so that e tends to 0 at least like factor^k"
        )
    return (
        f"For all matrices (A(k), C(k)) in {hull(count, states, outputs, is_single)}, and every solution of e(k+1) = "
        f"(A(k) - L C(k))e(k), {falls}. "
        "Hence for a plant x(k+1) = f(k, x, u), y = h(k, x) and the observer xhat(k+1) = f(k, xhat, u) + L(y - h(k, "
        "xhat)), as long as the mean Jacobians of f and h between xhat and x lie "
        "in this hull: that they do is a hypothesis, of which this certificate says nothing."
    )


def sector(k, low, high):
    """What is assumed of the increments of the k-th nonlinearity."""
    if low == -high:
        return f"|w_{k}| <= high |H_{k} e| for high = {exact(high)}"
    return f"(w_{k} - low H_{k} e)'(high H_{k} e - w_{k}) >= 0 for low = {exact(low)}, high = {exact(high)}"


def sector_observer(states, outputs, sectors, rate, is_single):
    varying = " It holds for e' = (A(t) - L C(t))e + sum_k G_k w_k where they vary in time, too."
    conditions = ", and ".join(sector(k + 1, low, high) for k, (low, high) in enumerate(sectors))
    return (
        f"For every plant x' = Ax + sum_k G_k phi_k(t, H_k x, u) + g(t, y, u), y = Cx with {counted(states, 'state')}, "
        f"{counted(outputs, 'output')} and {counted(len(sectors), 'nonlinearity', 'nonlinearities')}, "
        f"whose increments w_k = phi_k(t, H_k x, u) - phi_k(t, H_k xhat, u) satisfy {conditions}, "
        "and the observer xhat' = A xhat + sum_k G_k phi_k(t, H_k xhat, u) + g(t, y, u) + L(y - C xhat), "
        f"e = x - xhat: {decay(rate)}, from every e(0). That the nonlinearities of a plant satisfy this, where x and "
        f"xhat are, is a hypothesis.{'' if is_single else enclosed(is_single) + varying}"
    )


def input_to_state_stability(states, outputs, vertices, has_cubic, rate, disturbances, level, limsup, is_single):
    sizes = f"{counted(states, 'state')}, {counted(len(disturbances), 'disturbance')} and {counted(outputs, 'output')}"
    a, e = "A", "E"
    plant = f"the plant x' = Ax + Bu + Ew, y = Cx + Dw with {sizes}, any B and u"
    if vertices > 1:
        a, e = "A(t)", "E(t)"
        plant = (
            f"every plant x' = A(t)x + Bu + E(t)w, y = Cx + Dw with {sizes}, any B and u, whose pair (A(t), E(t)) lies "
            f"in the convex hull of the {vertices} pairs (A_k, E_k) at all times"
        )
    function, term = "V = e'Pe", "(r'theta r) N r"
    if has_cubic:
        function = (
            "V = e'P~e, P~ = C'XC + (I - T)(P - C'XC)(I - T) with the orthogonal projector T on the range of N,"
        )
    bounds = ", ".join(f"|w_{i + 1}| <= {at_least(x, 6)}" for i, x in enumerate(disturbances))
    limits = ", ".join(f"limsup |e_{i + 1}| <= {at_most(x, 4)}" for i, x in enumerate(limsup))
    return (
        f"For {plant}, all disturbances w with {bounds}, and the observer xhat' = {a} xhat + Bu + L r"
        f"{' - ' + term if has_cubic else ''}, r = y - C xhat, with the gains exactly as stored, "
        f"the error e = x - xhat obeys e' = ({a} - LC)e + ({e} - LD)w{' + ' + term if has_cubic else ''}; "
        f"{function} satisfies V(t) <= exp(-2 rate t) V(0) + level with rate = {at_least(rate, 4)} and level = "
        f"{at_most(level, 4)}, from every e(0); and {limits}.{enclosed(is_single)}"
    )


def magnitudes(bounds, name):
    return ", ".join(f"|{name}_{i + 1}| <= {at_least(x, 6)}" for i, x in enumerate(bounds))


def limits(bounds, name):
    return ", ".join(f"limsup {name}_{i + 1} <= {at_most(x, 4)}" for i, x in enumerate(bounds))


def interval_observer(states, outputs, w, blocks, rate, widths):
    return (
        f"For the plant x' = Ax + Bu + Ew, y = Cx + Dw with {counted(states, 'state')}, "
        f"{counted(len(w), 'disturbance')} and {counted(outputs, 'output')}, any B and u, all disturbances w with "
        f"{magnitudes(w, 'w')}, and the interval observer xhat' = A xhat + Bu + L(y - C xhat), rho' = K rho + g, with "
        "all matrices exactly as stored, in exact arithmetic: if at the start every block z_k of z = T(x - xhat), of "
        f"{', '.join(map(str, blocks))} entries, has |z_k| <= rho_k, this holds at all times, and "
        "|x_i - xhat_i| <= (H rho)_i; K is Metzler and Hurwitz, rho(t) <= limit + c exp(-rate t) s for some c, with "
        f"rate = {at_least(rate, 4)}; and {limits(widths, '(H rho)')}."
    )


def sampled_interval_observer(size, number, w, v, blocks, xhat, inputs, factor, widths, is_single):
    states, columns, disturbances, outputs = size
    disturbed = ", ".join(filter(None, (magnitudes(w, "w"), magnitudes(v, "v"))))
    kept = ", ".join(filter(None, (magnitudes(xhat, "xhat"), magnitudes(inputs, "u"))))
    return (
        f"For the sampled plant x+ = Ax + Bu + Ew, y = Cx + v with {counted(states, 'state')}, "
        f"{counted(columns, 'input')}, {counted(disturbances, 'disturbance')} and {counted(outputs, 'output')}, all w "
        f"and v with {disturbed}, y and u being numbers of {number}, and the interval observer xhat+ = F xhat + Gu + "
        "L(y - C xhat), rho+ = N rho + g + Q|xhat| + U|u|, r = H rho + outward |xhat|, its numbers exactly as stored, "
        f"each operation rounded to nearest in {number}, sums in any order, with or without fused multiply-adds, and no "
        "result beyond its range: if at the start rho >= g and every block z_k of z = T(x - xhat), of "
        f"{', '.join(map(str, blocks))} entries, has |z_k| <= rho_k, the latter holds at each step, and every x_i lies "
        f"between the computed xhat_i - r_i and xhat_i + r_i. While {kept}, rho(k) <= limit + c factor^k s for some c, "
        f"with factor = {exact(factor)}, and {limits(widths, 'r')}.{enclosed(is_single)}"
    )


def super_twisting_observer(k1, k2, bound, alpha, c):
    return (
        "For the error e1' = e2 - k1 |e1|^(1/2) sign(e1), e2' = F - k2 sign(e1) of a super-twisting observer in "
        f"continuous time with k1 = {exact(k1)}, k2 = {exact(k2)} and every F with |F(t)| <= {exact(bound)}: V = z'Pz, "
        "z = (|e1|^(1/2) sign(e1), e2), satisfies V' <= -(alpha/c) V^(1/2) almost everywhere with "
        f"alpha = {exact(alpha)} and c = {exact(c)}, so that e1 and e2 are 0 from a time of at most "
        "(2 c/alpha) V(0)^(1/2) on, from every initial error. Nothing is said of a sampled observer."
    )


def unknown_input_observer(states, inputs, unknown, outputs, has_cubic, rate):
    term, gains, flow, metric, function = "", "gain L", "", "", "e'Pe"
    if has_cubic:
        term, gains, flow, function = " - (r'theta r) N r", "gains L and N", " + (e'C'theta C e) N C e", "e'P~e"
        metric = ", with P~ = C'XC + (I - R)(P - C'XC)(I - R), R the orthogonal projector on the range of N"
    return (
        f"For the plant x' = Ax + Bu + Ed, y = Cx with {counted(states, 'state')}, {counted(inputs, 'input')}, "
        f"{counted(unknown, 'unknown input')} and {counted(outputs, 'output')}, any unknown input d, and the observer "
        f"z' = TA xhat + TBu + L r{term}, r = y - C xhat, xhat = z + Hy, with the real matrices "
        f"H = E((CE)'CE)^-1(CE)' and T = I - HC and the {gains} exactly as stored: TE = 0, the error e = x - xhat "
        f"obeys e' = (TA - LC)e{flow} whatever d is, and {decay(rate, function)}, from every e(0){metric}. "
        "Nothing is said of a rounding of H, TA and TB."
    )


def decoupling_observer(is_discrete, states, inputs, unknown, outputs):
    plant, following, step = ("discrete-time plant", "+", " at each step") if is_discrete else ("plant", "'", "")
    return (
        f"For the {plant} x{following} = Ax + Bu + Ed, y = Cx + Fd with {counted(states, 'state')}, "
        f"{counted(inputs, 'input')}, {counted(unknown, 'unknown input')} and {counted(outputs, 'output')}, any "
        f"unknown input d, and the observer z{following} = TA xhat + TBu + J r, r = y - C xhat, xhat = z + Hy, with the real "
        "matrices [H G] = [E - LF, 0] (S'S)^-1 S', J = L + G and T = I - HC, where S = [CE F1; F 0], F1 the columns of "
        "F that are not 0, and L exactly as stored: HF = 0 and TE = JF, the error e = x - xhat obeys "
        f"e{following} = (TA - JC)e whatever d is, V = e'Pe decreases{step}, and e tends to 0 exponentially, from "
        "every e(0). Nothing is said of a rounding of H, J, TA and TB."
    )


def reduced_order_observer(states, inputs, outputs, order, rate):
    decreases = decay(rate, "v'Pv", "v")
    return (
        f"For the plant x' = Ax + Bu, y = Cx with {sizes(states, inputs, outputs)} and the observer w' = Fw + TAN y + "
        f"TBu, xhat = Mw + Ny with {counted(order, 'state')}, T exactly as stored and the real matrices "
        "N = (C'C + T'T)^-1 C', M = (C'C + T'T)^-1 T' and F = TAM: v = w - Tx obeys v' = Fv, the error is "
        f"xhat - x = Mv, and {decreases}, from every v(0). Nothing is said of a rounding of the other "
        "matrices."
    )


def filter_bound(norm, is_discrete, states, inputs, disturbances, outputs, rows, gamma):
    plant, step = ("discrete-time plant", "+") if is_discrete else ("plant", "'")
    return (
        f"For the {plant} x{step} = Ax + Bu + Ew, y = Cx + Dw with {counted(states, 'state')}, "
        f"{counted(inputs, 'input')}, {counted(disturbances, 'disturbance')} and {counted(outputs, 'output')}, any u, "
        f"and the observer xhat{step} = A xhat + Bu + L(y - C xhat) with the gain exactly as stored, "
        f"the error e = x - xhat obeys e{step} = (A - LC)e + (E - LD)w. "
        f"Without w, e tends to 0 exponentially from every e(0), and the {norm} norm of the transfer function from w to "
        f"z = He with {counted(rows, 'row')} is below gamma = {exact(gamma)}"
    )


def h_infinity_filter(bound, is_discrete):
    energy = (
        "the sum of |z|^2 from the first sample to any other"
        if is_discrete
        else "the integral of |z|^2 from 0 to any T"
    )
    return f"{bound}: {energy} is at most e(0)'Pe(0) plus gamma^2 times that of |w|^2, for every w and e(0)."


def h2_filter(bound, is_discrete):
    noise = "covariance" if is_discrete else "intensity"
    return (
        f"{bound}: under white noise w of unit {noise} the sum of the variances of the entries of z is below gamma^2 in "
        "the end."
    )


def contracting_coordinates(count, measured, unmeasured, injection, rate):
    falls = decay(rate, "|d_m|^2 + d_w'Q d_w", "d")
    return (
        f"For all matrices J(t) in the convex hull of the {count} given, with {counted(measured, 'measured state')} "
        f"and {counted(unmeasured, 'unmeasured state')}, "
        "in the coordinates (d_m, d_w) = T^-1 d with T = [I 0; K I], every solution of d' = (T^-1 J(t) T - [G_m 0; 0 "
        "0])d with a diagonal "
        f"G_m(t) >= g I, g = {exact(injection)}, obeys: {falls}, from every d(0). "
        "That the mean Jacobians of a plant lie in this hull is a hypothesis, of which this certificate says nothing."
    )


def definiteness(n, sense, is_single):
    return f"The symmetric {n} x {n} matrix M is {sense}.{enclosed(is_single, 'M')}"


def solution_within(equation, n, is_single):
    return (
        f"The equation {equation} with the {n} x {n} matrices A and Q has exactly one solution. It is symmetric, and "
        "each of its entries lies between the bounds that P gives."
        f"{enclosed(is_single, 'Q')}"
    )


def combination(matrix, unknowns):
    """`x_1 F_1 + ... + x_m F_m`."""
    if unknowns == 0:
        return "0"
    if unknowns == 1:
        return f"x_1 {matrix}1"
    return f"x_1 {matrix}1 {'+ ... ' if unknowns > 2 else ''}+ x_{unknowns} {matrix}{unknowns}"


def inequality_label(relation, name):
    return f"F(x) {relation} 0 of {quoted(name)}"


def multiplier_label(name):
    return f"Z >= 0 of {quoted(name)}"


def inequalities(unknowns, relation, names):
    return (
        f"the linear matrix inequalities F_k(x) = F_k0 + {combination('F_k', unknowns)} {relation} 0, "
        f"{counted(len(names), 'constraint')} ({', '.join(map(quoted, names))})."
    )


def matrix_inequality_holds(unknowns, relation, names):
    return f"The x given satisfies {inequalities(unknowns, relation, names)}"


def matrix_inequality_refuted(unknowns, relation, names):
    return f"No x satisfies {inequalities(unknowns, relation, names)}"


def semidefinite_program(unknowns, blocks, claim, lower, upper):
    total = combination("F_", unknowns)
    program = f"the semidefinite program (P) min c'x subject to {total} - F_0 >= 0 with {counted(blocks, 'block')}"
    if claim == "primal infeasible":
        return f"For {program}: (P) has no feasible point."
    if claim == "dual infeasible":
        dual = "its dual (D) max tr(F_0 Y) subject to tr(F_i Y) = c_i, Y >= 0"
        return f"For {program} and {dual}: (D) has no feasible point."
    bounds = [] if lower is None else [f"every feasible point of (P) has c'x >= {exact(lower)}"]
    bounds += [] if upper is None else [f"(P) has a feasible point with c'x <= {exact(upper)}"]
    return f"For {program}: {', and '.join(bounds)}."


STEPS = {
    "cubic": (
        "the sampled cubic observer xhat+ = A(xhat - N i) + Bu + L j, i = z(1 - r)/w, j = r z, z = y - C xhat, "
        "r = 1/sqrt(1 + 2 w h max(z'theta z, 0)), h the period",
        "a plant of the stored A, B and C with v = 0 has e+ = M e with M = A - LC + g (AN + wL)C for some g, "
        "0 <= g < 1/w, that depends on e",
    ),
    "joined": (
        "the observer xhat+ = F xhat + Bu + Ly, F being the exact A - LC of the plant's A and C and the stored L, "
        "rounded once",
        "a plant with the stored B, with F + LC in the place of A and with v = 0 has e+ = F e",
    ),
    "innovation": (
        "the observer xhat+ = A xhat + Bu + L z, z = y - C xhat",
        "a plant of the stored A, B and C with v = 0 has e+ = (A - LC)e",
    ),
}
STEPS["accumulated"] = STEPS["innovation"]


def running_claim(step, stored, running, deviates):
    plant = "on the real plant"
    if deviates:
        plant = (
            "on every plant x+ = (A + dA)x + (B + dB)u whose |dA| and |dB| are at most operation.dA and operation.dB, "
            "entry by entry and perhaps differently in every step,"
        )
    flow, operands = "", "" if stored == running else "the stored numbers entering as they are, "
    if step == "cubic":
        flow = (
            " with i = (((k p)p')s)d and j = p d, s = max |z_k|, d = z/s, q = max(d'theta d, 0), k = (2q)h, "
            "b = sqrt(w k), c = b s, a = sqrt(1 + c c), p = s/a, p' = s/(1 + a), but p = p' = 1/b where c is larger "
            f"than {'2^52' if running == 'binary64' else '2^23'}, and i = j = z where s = 0,"
        )
    if step == "accumulated":
        rounded = "each sum of products computed without rounding, then rounded to nearest"
    elif running.startswith("Q"):
        rounded = "each product rounded to nearest or each sum of products as a whole"
    else:
        rounded = "each operation rounded to nearest, with or without fused multiply-adds"
    return (
        f"As it runs in {running},{flow} {rounded}, {operands}sums in any order, y rounded to nearest, u and xhat(0) "
        f"being numbers of {running}, {plant} and while |x|, |u|, |v| and |e(0)| keep the bounds of "
        "operation: the error e never makes sqrt(e'Pe) larger than running.start, limsup |e_i| is at most "
        "running.limsup[i] (counted from 0), and no result of any of these operations leaves the range of "
        f"{running}."
    )


def deployed_observer(states, inputs, outputs, step, stored, running, deviates):
    observer, error = STEPS[step]
    claim = running_claim(step, stored, running, deviates) if running else "Nothing is said of the rounding of its steps."
    return (
        f"For the sampled plant x+ = Ax + Bu, y = Cx + v with {sizes(states, inputs, outputs)}, and {observer}, "
        f"with all its matrices stored in {stored}, to nearest, ties to even: with the numbers exactly as stored and "
        f"in exact arithmetic, for the error e = x - xhat, {error}, V = e'Pe falls at each step at least by a factor "
        f"below 1 that is the same for all e, and e tends to 0 exponentially, from every e(0). {claim}"
    )


def kkl_error_bound(size, f, h, z, rows, b, inverse, x, u, phi, rate, limit, start, lipschitz, defect, eventual):
    gain = "; ".join(map(", ".join, rows))
    within = [
        f"{letter}{k} in [{exact(low)}, {exact(high)}]"
        for letter, ranges in (("x", x), ("u", u))
        for k, (low, high) in enumerate(ranges, 1)
    ]
    bounds = [
        f"|z{k} - zhat{k}| <= {exact(l)} V(t) + {exact(d)}" for k, (l, d) in enumerate(zip(lipschitz, defect), 1)
    ]
    limits = [f"limsup |z{k} - zhat{k}| <= {exact(e)}" for k, e in enumerate(eventual, 1)]
    return (
        f"For the plant x' = f(x, u), y = h(x) with {sizes(*size)}, f = ({', '.join(f)}), h = ({', '.join(h)}), and the "
        f"observer xi' = Lambda(u, y) xi + B(u, y), zhat = phi^L(xi, u, y) of z = ({', '.join(z)}) with Lambda = "
        f"[{gain}], B = ({', '.join(b)}) and phi^L = ({', '.join(inverse)}): along every solution that remains in the "
        f"box {', '.join(within)}, the error e = xi - phi(x) with phi = ({', '.join(phi)}) satisfies V(t) <= "
        "exp(-rate t) V(0) + (1 - exp(-rate t)) limit from every xi(0), for V = sqrt(e'Pe), rate = "
        f"{exact(rate)} and limit = {exact(limit)}. Whenever V(t) <= {exact(start)}, and at all times if V(0) is, "
        f"{', '.join(bounds)}. From every xi(0), {', '.join(limits)}."
    )


def kkl_injectivity(modulus, spread):
    return (
        " For all x and z in the box, |M ((phi, h)(x) - (phi, h)(z))| >= modulus |x - z| with modulus = "
        f"{exact(modulus)}; hence |x(t) - z| <= (spread V(t) + |M (xi - phi(z), y - h(z))|)/modulus with spread = "
        f"{exact(spread)}, for every z in the box."
    )
