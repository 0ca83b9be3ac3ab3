"""Nets in the manner of families of the Model Checking Contest, made here from what is published of them.

Each function makes a net of one size. They differ in kind: places for values, tokens in grids, workflows
without a way back, locks and mailboxes, counters that grow without bound, chains of chemistry.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping

from mcpn.nets.petri import NetBuilder, PetriNet

Maker = Callable[[int], PetriNet]


def _net(name: str, places: Mapping[str, int], moves: Iterable[tuple[str, str, str]]) -> PetriNet:
    """A net of places with their tokens and moves: a name, what it consumes, what it produces, as words."""
    net = NetBuilder(name)
    for place, tokens in places.items():
        net.place(place, initial=tokens)
    for transition, consume, produce in moves:
        net.transition(transition, consume=consume.split(), produce=produce.split())
    return net.build()


def forward_progress(size: int) -> PetriNet:
    """Threads of a GPU: each runs a short program, takes a lock, waits at a barrier."""
    places, moves = {"lock": 1, "shut": 1, "open": 0}, []
    for i in range(size):
        places |= {f"t{i}_{k}": int(k == 0) for k in range(9)} | {f"at{i}": 0, f"off{i}": 1}
        moves += [
            (f"start{i}", f"t{i}_0", f"t{i}_1"),
            (f"branch{i}", f"t{i}_1", f"t{i}_2"),
            (f"skip{i}", f"t{i}_1", f"t{i}_4"),
            (f"take{i}", f"t{i}_2 lock", f"t{i}_3"),
            (f"leave{i}", f"t{i}_3", f"t{i}_4 lock"),
            (f"arrive{i}", f"t{i}_4 off{i}", f"t{i}_5 at{i}"),
            (f"spin{i}", f"t{i}_5", f"t{i}_6"),
            (f"look{i}", f"t{i}_6", f"t{i}_5"),
            (f"pass{i}", f"t{i}_6 open", f"t{i}_7 open"),
            (f"end{i}", f"t{i}_7 at{i}", f"t{i}_8 off{i}"),
        ]
    every = " ".join(f"at{i}" for i in range(size))
    done, off = " ".join(f"t{i}_8" for i in range(size)), " ".join(f"off{i}" for i in range(size))
    moves += [
        ("barrier", f"shut {every}", f"{every} open"),
        ("again", f"open {done} {off}", f"shut {off} {done}"),
    ]
    moves += [(f"redo{i}", f"t{i}_8 off{i}", f"t{i}_0 off{i}") for i in range(0, size, 2)]
    return _net(f"forward-progress-{size}", places, moves)


def sieve(size: int) -> PetriNet:
    """Actors that sieve primes; each has a mailbox of one message."""
    count = max(2, size // 3)
    places, moves = {f"next_{v}": int(v == 2) for v in range(2, size + 1)}, []
    for a in range(count):
        places |= {f"idle{a}": 1, f"free{a}": 1}
        for v in range(2, size + 1):
            places |= {f"box{a}_{v}": 0, f"has{a}_{v}": 0}
            places |= {f"prime{a}_{v}": 0, f"pass{a}_{v}": 0}
    for v in range(2, size + 1):
        after = f"next_{v + 1}" if v < size else ""
        moves.append((f"send_{v}", f"next_{v} free0", f"{after} box0_{v}"))
    for a in range(count):
        for v in range(2, size + 1):
            moves.append((f"first{a}_{v}", f"box{a}_{v} idle{a}", f"free{a} prime{a}_{v}"))
            for p in range(2, v):
                held = f"prime{a}_{p}"
                if v % p == 0:
                    moves.append((f"drop{a}_{p}_{v}", f"box{a}_{v} {held}", f"free{a} {held}"))
                else:
                    moves.append((f"keep{a}_{p}_{v}", f"box{a}_{v} {held}", f"has{a}_{v} {held}"))
            if a + 1 < count:
                moves.append((f"on{a}_{v}", f"has{a}_{v} free{a + 1}", f"box{a + 1}_{v} free{a}"))
            else:
                moves.append((f"lost{a}_{v}", f"has{a}_{v}", f"free{a} pass{a}_{v}"))
    return _net(f"sieve-{size}", places, moves)


def stigmergy(size: int) -> PetriNet:
    """Robots that vote by marks which they copy from each other, and commit once all marks agree."""
    places, moves, values = {"leader": 1}, [], 3
    for i in range(size):
        places |= {f"m{i}_{v}": int(v == 0) for v in range(values)}
        places |= {f"s{i}_{k}": int(k == 0) for k in ("0", "seek", "said", "done", "off")} | {f"s{i}_0": 1}
        moves.append((f"wake{i}", f"s{i}_0", f"s{i}_seek"))
        for v in range(1, values):
            moves.append((f"mark{i}_{v}", f"s{i}_seek m{i}_0", f"s{i}_said m{i}_{v}"))
            for j in {(i + 1) % size, (i + 3) % size} - {i}:
                for w in range(values):
                    if w != v:
                        moves.append(
                            (
                                f"copy{i}_{j}_{w}{v}",
                                f"m{j}_{v} m{i}_{w} s{i}_seek",
                                f"m{j}_{v} m{i}_{v} s{i}_said",
                            )
                        )
            moves.append((f"doubt{i}_{v}", f"s{i}_said m{i}_{v}", f"s{i}_seek m{i}_{v}"))
            moves.append(
                (
                    f"commit{i}_{v}",
                    f"s{i}_said m{i}_{v} m{(i + 1) % size}_{v}" if size > 1 else f"s{i}_said m{i}_{v}",
                    f"s{i}_done m{i}_{v} m{(i + 1) % size}_{v}" if size > 1 else f"s{i}_done m{i}_{v}",
                )
            )
        moves.append((f"lead{i}", f"s{i}_done leader", f"s{i}_off leader"))
    return _net(f"stigmergy-{size}", places, moves)


def epidemic(size: int) -> PetriNet:
    """People on a grid who fall ill by their neighbours, recover, and are open again or not."""
    places, moves = {"vaccine": size}, []
    for x in range(size):
        for y in range(size):
            me = f"{x}_{y}"
            ill = int(x == y == 0)
            places |= {f"S{me}": 1 - ill, f"I{me}": ill, f"R{me}": 0}
            for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1)):
                u, w = x + dx, y + dy
                if 0 <= u < size and 0 <= w < size:
                    moves.append((f"fall{me}by{u}_{w}", f"S{me} I{u}_{w}", f"I{me} I{u}_{w}"))
            moves.append((f"heal{me}", f"I{me}", f"R{me}"))
            if (x + y) % 3 == 0:
                moves.append((f"wane{me}", f"R{me}", f"S{me}"))
            moves.append((f"jab{me}", f"S{me} vaccine", f"R{me}"))
    return _net(f"epidemic-{size}", places, moves)


def gcd(size: int) -> PetriNet:
    """Pairs of numbers around a ring, each the difference of two others, as places for values."""
    parts, most = 3, size
    draw = random.Random(size)
    first = [draw.randint(1, most) for _ in range(parts)]
    places = {f"n{i}_{v}": int(first[i] == v) for i in range(parts) for v in range(most + 1)}
    moves = []
    for i in range(parts):
        j = (i + 1) % parts
        for a in range(1, most + 1):
            for b in range(1, most + 1):
                if a > b:
                    moves.append((f"sub{i}_{a}_{b}", f"n{i}_{a} n{j}_{b}", f"n{i}_{a - b} n{j}_{b}"))
                elif a < b:
                    moves.append((f"bus{i}_{a}_{b}", f"n{i}_{a} n{j}_{b}", f"n{i}_{a} n{j}_{b - a}"))
    return _net(f"gcd-{size}", places, moves)


def exponent(size: int) -> PetriNet:
    """Counters in stages, each of which empties twice what it was given: many tokens in few places."""
    places, moves = {"go0": 1, "end": 0}, []
    for i in range(size):
        places |= {f"x{i}": 0, f"y{i}": 0, f"up{i}": 0, f"dn{i}": 0, f"a{i}": 0, f"b{i}": 0}
        places |= {f"go{i + 1}": 0}
        moves += [
            (f"set{i}", f"go{i}", f"up{i} x{i}"),
            (f"dbl{i}", f"up{i} x{i}", f"a{i} y{i} y{i}"),
            (f"more{i}", f"a{i}", f"up{i}"),
            (f"turn{i}", f"a{i}", f"dn{i}"),
            (f"back{i}", f"dn{i} y{i}", f"b{i} x{i}"),
            (f"loop{i}", f"b{i}", f"dn{i}"),
            (f"flip{i}", f"b{i}", f"up{i}"),
            (f"next{i}", f"dn{i} x{i}", f"go{i + 1}"),
        ]
    moves.append(("stop", f"go{size}", "end"))
    return _net(f"exponent-{size}", places, moves)


def pointers(size: int) -> PetriNet:
    """Calls by a table of functions: a stack of places for who called whom."""
    places, moves = {f"pc_{k}": int(k == 0) for k in range(size)}, []
    for d in range(4):
        places |= {f"st{d}_{k}": 0 for k in range(size)} | {f"free{d}": int(d == 0)}
    draw = random.Random(size)
    for k in range(size):
        for n, target in enumerate(draw.sample(range(size), min(3, size))):
            moves.append((f"jump{k}_{n}", f"pc_{k}", f"pc_{target}"))
            for d in range(4):
                on = f"free{d + 1}" if d < 3 else ""
                moves.append((f"call{d}_{k}_{n}", f"pc_{k} free{d}", f"pc_{target} st{d}_{k} {on}"))
        for d in range(4):
            on = f"free{d + 1}" if d < 3 else ""
            for target in draw.sample(range(size), min(4, size)):
                moves.append((f"ret{d}_{k}_{target}", f"pc_{k} st{d}_{target} {on}", f"pc_{target} free{d}"))
    return _net(f"pointers-{size}", places, moves)


def clients(size: int) -> PetriNet:
    """Clients that each choose one of several servers, which serve one at a time."""
    servers = max(2, size // 4)
    places, moves = {f"srv{s}": 1 for s in range(servers)}, []
    for c in range(size):
        places |= {f"rest{c}": 1}
        for s in range(servers):
            at = f"{c}_{s}"
            places |= {f"ask{at}": 0, f"on{at}": 0, f"ans{at}": 0, f"wait{at}": 0}
            moves += [
                (f"req{at}", f"rest{c}", f"ask{at} wait{at}"),
                (f"acc{at}", f"ask{at} srv{s}", f"on{at}"),
                (f"work{at}", f"on{at}", f"ans{at} srv{s}"),
                (f"take{at}", f"ans{at} wait{at}", f"rest{c}"),
            ]
    return _net(f"clients-{size}", places, moves)


def houses(size: int) -> PetriNet:
    """Many houses that are built by one plan: a workflow that forks and joins, and comes to an end."""
    steps = {
        "plan": ("p1", "p2 p3"),
        "dig": ("p2", "p4"),
        "buy": ("p3", "p5 p6"),
        "lay": ("p4 p5", "p7"),
        "wall": ("p7", "p8 p9"),
        "roof": ("p8 p6", "p10"),
        "wire": ("p9", "p11 p12"),
        "pipe": ("p11", "p13"),
        "heat": ("p12", "p14"),
        "tile": ("p10 p13", "p15"),
        "paint": ("p14", "p16"),
        "see": ("p15 p16", "p17"),
        "sell": ("p17", "p18"),
    }
    places = {f"p{k}": size * (k == 1) for k in range(1, 19)}
    return _net(f"houses-{size}", places, [(name, *sides) for name, sides in steps.items()])


def diffusion(size: int) -> PetriNet:
    """Particles that wander over a grid to any of eight neighbours."""
    places = {f"c{x}_{y}": 10 * size * (x == y == size // 2) for x in range(size) for y in range(size)}
    moves = [
        (f"m{x}_{y}to{u}_{w}", f"c{x}_{y}", f"c{u}_{w}")
        for x in range(size)
        for y in range(size)
        for u in range(x - 1, x + 2)
        for w in range(y - 1, y + 2)
        if (u, w) != (x, y) and 0 <= u < size and 0 <= w < size
    ]
    return _net(f"diffusion-{size}", places, moves)


def process(size: int) -> PetriNet:
    """A business process: blocks of choices, forks and loops inside each other, drawn; 1-safe, it ends."""
    draw, places, moves = random.Random(size), {"in": 1, "out": 0}, []

    def block(begin: str, end: str, left: int) -> None:
        if left <= 1:
            moves.append((f"t{len(moves)}", begin, end))
            return
        middle = [f"p{len(places) + k}" for k in range(4)]
        places.update(dict.fromkeys(middle, 0))
        a, b, c, d = middle
        kind = draw.choice(("row", "row", "fork", "choice", "loop"))
        part = draw.randint(1, left - 1)
        if kind == "row":
            block(begin, a, part)
            moves.extend([(f"t{len(moves)}", a, b)])
            moves.extend([(f"t{len(moves)}", b, c)])
            moves.extend([(f"t{len(moves)}", c, d)])
            block(d, end, left - part)
            return
        if kind == "fork":
            moves.append((f"t{len(moves)}", begin, f"{a} {b}"))
            moves.append((f"t{len(moves)}", f"{c} {d}", end))
        elif kind == "choice":
            moves.append((f"t{len(moves)}", begin, a))
            moves.append((f"t{len(moves)}", begin, b))
            moves.append((f"t{len(moves)}", c, end))
            moves.append((f"t{len(moves)}", d, end))
        else:
            moves.append((f"t{len(moves)}", begin, a))
            moves.append((f"t{len(moves)}", c, b))
            moves.append((f"t{len(moves)}", d, a))
            moves.append((f"t{len(moves)}", c, end))
        block(a, c, part)
        block(b, d, left - part)

    block("in", "out", size)
    return _net(f"process-{size}", places, moves)


def packets(size: int) -> PetriNet:
    """A square of routers with bounded buffers that pass packets on between their sides."""
    places, moves = dict[str, int](), []
    sides = {"n": (0, -1), "e": (1, 0), "s": (0, 1), "w": (-1, 0)}
    back = {"n": "s", "e": "w", "s": "n", "w": "e"}
    for x in range(size):
        for y in range(size):
            me = f"{x}_{y}"
            places |= {f"room{me}": 4, **{f"q{me}{side}": 1 for side in sides}}
            for side, (dx, dy) in sides.items():
                u, w = x + dx, y + dy
                places |= {f"o{me}{side}": 0}
                for other in sides:
                    if other != side:
                        moves.append((f"r{me}{side}{other}", f"q{me}{side} room{me}", f"o{me}{other}"))
                if 0 <= u < size and 0 <= w < size:
                    moves.append((f"s{me}{side}", f"o{me}{side}", f"q{u}_{w}{back[side]} room{me}"))
                else:
                    moves.append((f"s{me}{side}", f"o{me}{side}", f"q{me}{side} room{me}"))
    return _net(f"packets-{size}", places, moves)


def cascade(size: int) -> PetriNet:
    """Kinases that pass a signal on by binding, each undone by a phosphatase: everything can go back."""
    places, moves = {"k0": size, "phase": 3 * size}, []
    for i in range(1, 4):
        places |= {
            f"x{i}": 4 * size,
            f"xp{i}": 0,
            f"xpp{i}": 0,
            f"b{i}": 0,
            f"bb{i}": 0,
            f"u{i}": 0,
            f"uu{i}": 0,
        }
        by = "k0" if i == 1 else f"xpp{i - 1}"
        moves += [
            (f"bind{i}", f"{by} x{i}", f"b{i}"),
            (f"loose{i}", f"b{i}", f"{by} x{i}"),
            (f"phos{i}", f"b{i}", f"{by} xp{i}"),
            (f"bind2{i}", f"{by} xp{i}", f"bb{i}"),
            (f"loose2{i}", f"bb{i}", f"{by} xp{i}"),
            (f"phos2{i}", f"bb{i}", f"{by} xpp{i}"),
            (f"dep{i}", f"phase xpp{i}", f"u{i}"),
            (f"dep2{i}", f"u{i}", f"phase xp{i}"),
            (f"dip{i}", f"phase xp{i}", f"uu{i}"),
            (f"dip2{i}", f"uu{i}", f"phase x{i}"),
        ]
    return _net(f"cascade-{size}", places, moves)


def operating(size: int) -> PetriNet:
    """Tasks that need memory, a disk controller and a processor of a small operating system."""
    places = {"free": 2 * size, "tasks": 0, "cpu": size, "disk": size // 2 + 1, "ready": 0, "on": 0}
    places |= {"loaded": 0, "io": 0, "moving": 0, "out": 4 * size, "swap": 0}
    return _net(
        f"operating-{size}",
        places,
        [
            ("new", "free out", "tasks"),
            ("load", "tasks disk", "moving"),
            ("moved", "moving", "ready disk"),
            ("run", "ready cpu", "on"),
            ("pre", "on", "ready cpu"),
            ("ask", "on disk", "io cpu"),
            ("got", "io", "loaded disk"),
            ("on", "loaded", "ready"),
            ("end", "on", "free cpu out"),
            ("swapout", "ready disk", "swap free disk"),
            ("swapin", "swap free", "tasks"),
        ],
    )


def marked_graph(size: int) -> PetriNet:
    """A marked graph that is refined again and again: counters of tokens in cycles that share transitions."""
    places, moves = {f"c{i}": 5 * size for i in range(size)}, []
    for i in range(size):
        places |= {f"a{i}": 0, f"b{i}": 0, f"d{i}": 0, f"e{i}": 0, f"f{i}": 0, f"g{i}": 1, f"h{i}": 3 * size}
        before, room = (f"f{i - 1}", f"h{i - 1}") if i else ("", "")
        after, taken = (f"f{i}", f"h{i}") if i + 1 < size else ("", "")
        moves += [
            (f"in{i}", f"c{i} {before}", f"a{i} b{i} {room}"),
            (f"l{i}", f"a{i} g{i}", f"d{i}"),
            (f"m{i}", f"d{i}", f"e{i} g{i}"),
            (f"out{i}", f"e{i} b{i} {taken}", f"c{i} {after}"),
        ]
    return _net(f"marked-graph-{size}", places, moves)


def quorum(size: int) -> PetriNet:
    """Servers that certify by majority: some fail silently, a client gathers answers and may give up."""
    need = size // 2 + 1
    places = {"client": 1, "asked": 0, "votes": 0, "ok": 0, "no": 0, "faults": size // 3}
    moves = []
    for i in range(size):
        places |= {f"up{i}": 1, f"got{i}": 0, f"voted{i}": 0, f"bad{i}": 0, f"link{i}": 0}
        moves += [
            (f"get{i}", f"link{i} up{i}", f"got{i}"),
            (f"vote{i}", f"got{i}", f"voted{i} votes"),
            (f"fail{i}", f"got{i} faults", f"bad{i}"),
            (f"die{i}", f"up{i} faults", f"bad{i}"),
            (f"void{i}", f"link{i} bad{i}", f"bad{i}"),
        ]
    net = NetBuilder(f"quorum-{size}")
    for place, tokens in places.items():
        net.place(place, initial=tokens)
    for name, consume, produce in moves:
        net.transition(name, consume=consume.split(), produce=produce.split())
    net.transition("ask", consume=["client"], produce=["asked", *(f"link{i}" for i in range(size))])
    net.transition("done", consume={"asked": 1, "votes": need}, produce=["ok"])
    net.transition("giveup", consume=["asked"], produce=["no"])
    return net.build()


def array_lock(size: int) -> PetriNet:
    """Anderson's lock: a slot for each process, a counter modulo their number; each spins on its slot."""
    places = {f"slot{k}": int(k == 0) for k in range(size)} | {f"next{k}": int(k == 0) for k in range(size)}
    moves = []
    for i in range(size):
        places |= {f"idle{i}": 1} | {
            f"{what}{i}_{k}": 0 for what in ("wait", "in", "out") for k in range(size)
        }
        for k in range(size):
            nk = (k + 1) % size
            moves += [
                (f"take{i}_{k}", f"idle{i} next{k}", f"wait{i}_{k} next{nk}"),
                (f"enter{i}_{k}", f"wait{i}_{k} slot{k}", f"in{i}_{k}"),
                (f"work{i}_{k}", f"in{i}_{k}", f"out{i}_{k}"),
                (f"leave{i}_{k}", f"out{i}_{k}", f"idle{i} slot{nk}"),
            ]
    return _net(f"array-lock-{size}", places, moves)


def bridge(size: int) -> PetriNet:
    """Vehicles on both sides of a bridge that bears a few; a guard lets so many of one side pass."""
    most, turns = size // 2 + 1, 3
    places = {"left": size, "right": size, "on": 0, "no": 0, "room": most, "over": 0, "come": 0}
    places |= {f"{side}{k}": int(side == "L" and k == 0) for side in "LR" for k in range(turns + 1)}
    moves = []
    for side, here, there in (("L", "left", "come"), ("R", "right", "over")):
        on = "on" if side == "L" else "no"
        for k in range(turns):
            moves.append((f"in{side}{k}", f"{here} room {side}{k}", f"{on} {side}{k + 1}"))
        moves.append((f"out{side}", on, f"{there} room"))
        other = "R" if side == "L" else "L"
        for k in range(turns + 1):
            full = " ".join(["room"] * most)
            moves.append((f"turn{side}{k}", f"{side}{k} {full}", f"{other}0 {full}"))
    return _net(f"bridge-{size}", places, moves)


def growing_queue(size: int) -> PetriNet:
    """Producers and consumers whose queues have no bound; who consumes pays by credits that come back."""
    places, moves = {"credit": size}, []
    for i in range(size):
        places |= {f"src{i}": 1, f"q{i}": 0, f"w{i}": 0, f"log{i}": 0, f"stop{i}": 0}
        moves += [
            (f"put{i}", f"src{i}", f"src{i} q{i}"),
            (f"halt{i}", f"src{i}", f"stop{i}"),
            (f"get{i}", f"q{i} credit", f"w{i}"),
            (f"done{i}", f"w{i}", f"credit log{i}"),
        ]
        if i + 1 < size:
            moves.append((f"pass{i}", f"log{i}", f"q{i + 1}"))
    return _net(f"growing-queue-{size}", places, moves)


MADE: Mapping[str, tuple[Maker, tuple[int, ...], tuple[int, ...]]] = {
    "forward_progress": (forward_progress, (2,), (6, 20)),
    "sieve": (sieve, (5,), (9, 20)),
    "stigmergy": (stigmergy, (2,), (6, 12)),
    "epidemic": (epidemic, (2,), (4, 10)),
    "gcd": (gcd, (4,), (8, 20)),
    "exponent": (exponent, (), (2, 10)),
    "pointers": (pointers, (4,), (12, 60)),
    "clients": (clients, (2,), (12, 40)),
    "houses": (houses, (1,), (5, 50)),
    "diffusion": (diffusion, (), (5, 20)),
    "process": (process, (12,), (80, 400)),
    "packets": (packets, (), (2, 5)),
    "cascade": (cascade, (1,), (4, 40)),
    "operating": (operating, (1,), (8, 64)),
    "marked_graph": (marked_graph, (1,), (4, 10)),
    "quorum": (quorum, (3,), (10, 24)),
    "array_lock": (array_lock, (2,), (5, 10)),
    "bridge": (bridge, (2,), (8, 40)),
    "growing_queue": (growing_queue, (), (3, 12)),
}
"""Families, their small and their large sizes."""
