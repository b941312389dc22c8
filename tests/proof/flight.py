"""Check that the gaps stay open during a flight between two impacts; used to check certificates."""

from series import UNIT, ball, need

#: Number of times an interval of time may be halved.
MOST_HALVINGS = 22
#: Number of parts of a flight at whose ends a closed gap is sought, and of bisections that narrow an extremum.
PARTS, NARROWED = 512, 40


def closes(at, tau):
    """Whether a distance is proven to be negative at a time before tau; at(t) gives it and its rate of either
    sign."""
    times = [(tau.lower() * k / PARTS).mid() for k in range(1, PARTS)]
    found = [at(t) for t in times]
    if any(distance < 0 for distance, _ in found):
        return True
    falls = [rate.mid() < 0 for _, rate in found]
    for low, high, first, last in zip(times, times[1:], falls, falls[1:], strict=False):
        # a gap that closes for a short time does so around an extremum
        for _ in range(NARROWED if first != last else 0):
            middle = ((low + high) / 2).mid()
            distance, rate = at(middle)
            if distance < 0:
                return True
            low, high = (middle, high) if (rate.mid() < 0) == first else (low, middle)
    return False


class Flight:
    """Y and x in a flight, at times that are points or intervals."""

    def __init__(self, pair, i, start, end):
        self.pair, self.start, self.tau = pair, start, ball((end[0] - start[0]) / pair.r)
        self.free, (self.x, self.v) = pair.free(start), pair.steady(start[0])
        self.first, self.last = pair.sides[i], pair.side(i)

    def at(self, t):
        """The distance to the nearer wall, Y', Y'', x, x', x''."""
        pair, (x, v) = self.pair, self.pair.damped(*self.free, t)
        sine, cosine = (pair.r * t).sin(), (pair.r * t).cos()
        steady, rate = (
            self.x * cosine + self.v * sine / pair.r,
            self.v * cosine - self.x * sine * pair.r,
        )
        bend = ball(-2 * pair.xi * v - x - pair.r * pair.r * steady)
        y = self.start[1] + self.start[3] * t - x - steady
        walls = [ball(pair.d * ((1 - side * self.first) // 2) - y * side) for side in (1, -1)]
        speeds = ball(self.start[3] - v - rate), -bend, ball(x + steady), ball(v + rate), bend
        return walls[0].min(walls[1]), *speeds

    def ranges(self, low, high):
        """Distance, Y' and x from `low` to `high`, by the mean value theorem."""
        middle, spread = (low + high) / 2, UNIT * ((high - low) / 2)
        _, _, bend, _, _, x_bend = self.at(middle + spread)
        near, rate, _, x, x_rate, _ = self.at(middle)
        rate, x_rate = rate + bend * spread, x_rate + x_bend * spread
        return near - abs(rate * spread), rate, x + x_rate * spread

    def check(self, bound):
        """Check that both gaps stay open, and |x| <= bound."""
        ends = [self.tau.upper() * k / 32 for k in range(33)]
        pieces = [(ends[k], ends[k + 1], 0) for k in range(32)][::-1]
        # the sign of Y' on the previous piece; None if the gaps are open on all of it
        before = None
        while pieces:
            low, high, depth = pieces.pop()
            near, rate, x = self.ranges(low, high)
            sign = 1 if rate > 0 else -1 if rate < 0 else 0
            good = near > 0 or sign != 0
            if not near > 0 and sign and before not in (None, sign):
                good = self.at(low)[0] > 0
            if not high < self.tau:
                good = good and sign == self.last
            if not (good and (bound is None or abs(x) <= bound)):
                need(depth < MOST_HALVINGS, "a flight is not proven to stay between the walls")
                middle = ((low + high) / 2).mid()
                pieces += [(middle, high, depth + 1), (low, middle, depth + 1)]
                continue
            before = None if near > 0 else sign
