"""Call the C interface with hostile arguments, and send random messages and links to the explorer."""

import ctypes
import functools
import json
import math
import random
import threading
from urllib.parse import quote, urlencode

from child import in_child, limited, where
from language import Language

#: Numbers of library calls, messages and links in a full run.
CALLS, MESSAGES, LINKS = 200_000, 5_000, 5_000
SYSTEM = b"&system xi = 0.01, mu = 0.05, restitution = 0.75, r = 0.9 /\n"
CASE = SYSTEM + b"&motion kind = 'equispaced', clearance = 37 /"


def fuzz(report, options):
    """Run all tests of this file."""
    import vibroimpact as vi
    from vibroimpact.explorer import session  # noqa: F401  (before a call that may be interrupted)

    vi.equispaced(vi.Oscillator(xi=0.01, mu=0.05, restitution=0.75), 0.9, 37.0)
    for what, work, count in (
        ("calls from C", call, CALLS),
        ("messages", listen, MESSAGES),
        ("links", follow, LINKS),
    ):
        number = max(2, round(count * options.share))
        found = functools.partial(work, options, number)
        in_child(report, f"doors, {what}", what, found)


# -- the library


def call(options, count, begin):
    """Call all functions at random; any status is an acceptable answer."""
    library = ctypes.CDLL(str(next(options.checked.resolve().glob("src/c/libvibroimpact.so"))))
    for name in ("text", "describe", "version", "word"):
        getattr(library, f"vibroimpact_{name}").restype = ctypes.c_size_t
    rng = random.Random(f"{options.seed} calls")
    handles = []
    column, table = (ctypes.create_string_buffer(2000) for _ in range(2))
    out = ctypes.create_string_buffer(64)
    numbers = (ctypes.c_double * 64)()
    wholes = (ctypes.c_int32 * 64)(*(rng.choice((0, 1, 2, -1, 2**31 - 1)) for _ in range(64)))
    language = [CASE, CASE.replace(b"motion", b"find"), b"", b"\xff", b"&", b"x" * 5000, None]
    names = [
        b"motions",
        b"impacts",
        b"clearance",
        b"X",
        b"sides",
        b"multipliers",
        b"",
        b"x" * 300,
        b"\xff",
        None,
    ]

    def whole():
        return ctypes.c_int(
            rng.choice((0, 1, 2, 3, 4, 7, 8, -1, 2**31 - 1, -(2**31), rng.randrange(64)))
        )

    def few():
        return ctypes.c_int(rng.choice((0, 1, 2, 3, 8, 64, -1, -(2**31))))

    def handle():
        return ctypes.c_int64(rng.choice([0, *handles]))

    def name():
        return ctypes.c_char_p(rng.choice(names))

    def text():
        given = rng.choice(language)
        return ctypes.c_char_p(
            Language.damage(rng, given).replace(b"\0", b"")
            if given and rng.random() < 0.5
            else given
        )

    def room():
        return rng.choice(
            [(None, ctypes.c_size_t(0)), *((out, ctypes.c_size_t(n)) for n in (0, 1, 2, 64))]
        )

    for i in range(count):
        kind = rng.randrange(16)
        begin(f"call {i} of kind {kind}") if i % 100 == 0 else None
        fresh = ctypes.c_int64()
        if kind == 0 and len(handles) < 8:
            maker = rng.choice((library.vibroimpact_cases, library.vibroimpact_new))
            maker(text(), ctypes.byref(fresh))
            handles.append(fresh.value)
        elif kind == 1 and len(handles) < 8:
            progress = (ctypes.c_int32 * 3)()
            clock = threading.Timer(5, progress.__setitem__, (2, 1))
            clock.start()
            library.vibroimpact_run(text(), whole(), progress, ctypes.byref(fresh))
            clock.cancel()
            handles.append(fresh.value)
        elif kind == 2 and handles:
            library.vibroimpact_free(ctypes.c_int64(handles.pop(rng.randrange(len(handles)))))
        elif kind == 3:
            library.vibroimpact_text(handle(), whole(), *room())
        elif kind == 4:
            library.vibroimpact_table(handle(), whole(), rng.choice((table, None)))
        elif kind == 5:
            library.vibroimpact_column(handle(), whole(), rng.choice((column, None)))
        elif kind == 6:
            library.vibroimpact_find(handle(), name(), name(), rng.choice((column, None)))
        elif kind == 7:
            library.vibroimpact_word(handle(), whole(), whole(), *room())
        elif kind == 8:
            library.vibroimpact_write(
                handle(),
                ctypes.c_char_p(rng.choice((b"x.csv", b"no/x.csv", b"", None, b"."))),
                *room(),
            )
        elif kind == 9:
            parent = rng.choice((None, b"motions", b"x"))
            library.vibroimpact_open(handle(), name(), ctypes.c_char_p(rng.choice((b"motion", b"a b", b"a b c",
            b"", None))),
                                     ctypes.c_int(rng.choice((0, 1, 2, 3, 4, -1))), rng.choice((wholes, None)),
                                     parent, few(),
                                     rng.choice((wholes, None)))  # fmt: skip
        elif kind == 10:
            library.vibroimpact_put_reals(
                handle(), name(), name(), few(), rng.choice((numbers, None))
            )
        elif kind == 11:
            library.vibroimpact_put_wholes(
                handle(), name(), name(), few(), rng.choice((wholes, None))
            )
        elif kind == 12:
            library.vibroimpact_put_words(
                handle(), name(), name(), few(), rng.choice((wholes, None)), name()
            )
        elif kind == 13:
            library.vibroimpact_say(handle(), name(), name())
        elif kind == 14:
            library.vibroimpact_status(handle())
            library.vibroimpact_line(handle())
        else:
            library.vibroimpact_version(*room())
    return 0, count, {}


# -- the explorer


def odd(rng, depth=0):
    """A value that JSON can contain."""
    kind = rng.randrange(9 if depth < 3 else 7)
    if kind == 7:
        return [odd(rng, depth + 1) for _ in range(rng.randrange(4))]
    if kind == 8:
        return {str(odd(rng, 3)): odd(rng, depth + 1) for _ in range(rng.randrange(4))}
    return rng.choice((
        None, True, False, 0, 1, -1, 0.94, 1.0, 37, 25.5, 1e-300, 1e300, 2**70, math.nan, math.inf, -math.inf,
        "", "x", "0.5",
        "RL", "RRL", "1e400", "nan", "namelist", "python", "x" * 1999, "x" * 3000, "\0", "\u00e9", "<script>",
        "../x",
        rng.uniform(-2, 2), rng.uniform(0, 200),
    ))  # fmt: skip


def answered(session, sent, message, counts, faults):
    """One message to a session."""
    from vibroimpact.base.errors import VibroimpactError
    from vibroimpact.explorer.messages import checked

    data = repr(message).encode("utf-8", "replace")
    sent.clear()
    error = limited(lambda: session.heard(checked(message)), 20)
    if error is None:
        own = next((text for text in sent if "explorer's own" in text), None)
        if own is not None:
            at = own.index("internal error of the explorer")
            faults.setdefault(own[at : at + 200], (data, ".txt"))
        counts[1] += 1
    elif isinstance(error, VibroimpactError):
        counts[0] += 1
    elif isinstance(error, KeyboardInterrupt):
        faults.setdefault("does not end", (data, ".txt"))
    else:
        faults.setdefault(where(error), (data, ".txt"))


def listen(options, count, begin):
    """Send random messages to a page, in valid and invalid forms."""
    from vibroimpact.explorer.messages import PARTS
    from vibroimpact.explorer.session import Session
    from vibroimpact.explorer.state import State

    rng = random.Random(f"{options.seed} messages")
    fields = [*State.__dataclass_fields__]
    counts, faults, sent = [0, 0], {}, []
    session = None
    for i in range(count):
        begin(f"message {i}")
        if session is None or i % 50 == 0:
            if session is not None:
                session.close()
            session = Session("", lambda text, _: sent.append(text), lambda work: None)
        kind = rng.choice([*PARTS, "x", None, []])
        message = {"kind": kind, "number": i if rng.random() < 0.9 else odd(rng)}
        for name in PARTS.get(kind, {}) if isinstance(kind, str) else ():
            if name == "words":
                message[name] = {
                    rng.choice([*fields, "x"]): str(odd(rng, 3)) for _ in range(rng.randrange(4))
                }
            elif rng.random() < 0.6:
                message[name] = rng.choice(
                    (0.94, 1.04, 37.0, -1.0, True, False, [1.0, 25.0], None, "python")
                )
            else:
                message[name] = odd(rng)
        if rng.random() < 0.05:
            message = odd(rng)
        elif rng.random() < 0.5:
            message = json.loads(json.dumps(message))
        answered(session, sent, message, counts, faults)
    session.close()
    return *counts, faults


def follow(options, count, begin):
    """Open pages by random links."""
    from vibroimpact.explorer.state import State

    rng = random.Random(f"{options.seed} links")
    sound = State().query
    fields = [*State.__dataclass_fields__, "x"]
    counts, faults = [0, 0], {}
    for _ in range(count):
        if rng.random() < 0.5:
            link = Language.damage(rng, sound.encode() or b"r=1").decode("latin-1")
        else:
            link = urlencode(
                [(rng.choice(fields), str(odd(rng, 3))) for _ in range(rng.randrange(6))],
                errors="replace",
            )
        link = link if rng.random() < 0.8 else quote(link, errors="replace")
        begin(link)
        states = []

        def read(link=link, states=states):
            states.append(State.read(link))
            State.read(states[0][0].query)

        error = limited(read, 5)
        if error is None:
            counts[0 if states[0][1] else 1] += 1
        elif isinstance(error, KeyboardInterrupt):
            faults.setdefault("does not end", (link.encode("utf-8", "replace"), ".txt"))
        else:
            faults.setdefault(where(error), (link.encode("utf-8", "replace"), ".txt"))
    return *counts, faults
