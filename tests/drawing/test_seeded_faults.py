"""Faults seeded in the templates' nets: the proof refuses what every interleaving refuses.

Each named fault stands with why it matters on its mission. *Refused* are nets that are not 1-safe, have an
internal run that does not end, or an event with several ends; what only keeps a mission from its end is seen
by a verdict. A few faults change nothing, each for a reason.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.verdicts.mission import check
from mcpn.composite.explored_section import explore_local
from mcpn.drawing.compose import compose
from mcpn.errors import ConfluenceError, DivergenceError, UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.markings.explicit import KernelNet, explore
from mcpn.spaces.stable.alternatives import by_reduction, direct
from mcpn.spaces.stable.run_to_completion import Orders, settled
from mcpn.testing.kit.corpus import MISSIONS
from tests.drawing.seeding import Fault, Seed, single
from tests.kernel.test_stubborn import judged_alike

MOST = 20_000


def unranked(net: PetriNet) -> PetriNet:
    """All internal transitions have one rank."""
    return replace(net, transitions=tuple(replace(t, rank=0) for t in net.transitions))


UNSAFE, ENDLESS, PARTED = "unsafe", "endless", "parted"


class Case(NamedTuple):
    """A fault, what is seen of it (any of several, where the net has several faults then), and why."""

    of: str
    fault: Fault
    seen: frozenset[str]
    why: str


def case(of: str, fault: Fault, seen: str, why: str) -> Case:
    return Case(of, fault, frozenset(seen.split()), why)


REFUSED = [
    # Races: what should wait does not, or what should not wait does
    case("asks again", Seed("fires with", "p_stop2", "", "s_1_a"), PARTED,
         "as c fails a gives s back and asks anew: p stops in between and begins with h, or goes on"),
    case("asks again", Seed("fires with", "s_1_a", "", "p_stop2"), PARTED,
         "the request comes when p may stop already"),
    case("asks again", Seed("fires with", "a_sel2", "", "p_stop2"), PARTED,
         "a selects its next alternative when p may stop already"),
    case("asks again", Seed("fires with", "c_4", "", "p_stop2"), PARTED,
         "c is out of service, so that a can go on, when p may stop already"),
    case("asks again", Seed("fires with", "a_else1_c", "", "p_stop2"), PARTED,
         "a passes over its first alternative when p may stop already"),
    case("asks again", unranked, PARTED, "nothing waits for anything"),
    case("one after the other", Seed("fires with", "OBJ_y_begin", "", "p_stop2"), PARTED,
         "b of the next objective finds p as the last one has left it, or stopped"),
    case("one after the other", Seed("fires with", "p_stop2", "", "OBJ_y_begin"), PARTED,
         "p stops when the next objective may have begun"),
    case("one after the other", Seed("fires with", "s_4_a", "", "OBJ_y_begin"), PARTED,
         "s is given back when the next objective may have begun"),
    # Missing reads
    case("branches", Seed("does not read", "s_2_a", "p_running"), ENDLESS,
         "a gets its datum while p is refused, loses it at once, asks again"),
    case("branches", Seed("does not read", "s_3_a", "p_refusing"), PARTED,
         "a request may be refused and answered"),
    case("branches", Seed("does not read", "s_6_a", "p_refusing"), ENDLESS,
         "a loses its datum while p runs, and asks again"),
    case("branches", Seed("does not read", "p_start0", "s_waiting_a"), ENDLESS,
         "p starts though nobody asks, stops, and starts"),
    case("branches", Seed("does not read", "p_else1_h", "h_OOS"), PARTED,
         "p may pass over an alternative that is possible"),
    case("branches", Seed("does not read", "a_go1", "s_answer_a"), ENDLESS,
         "a runs before its request is refused, gives up, and asks again"),
    case("shared hardware", Seed("does not read", "a_sel1", "c_free"), PARTED,
         "a asks for hardware that fails and may get ahead of its going out of service"),
    case("retried", Seed("does not read", "a_back2_h", "h_service"), ENDLESS,
         "a returns to an alternative that is not possible, for ever"),
    case("four data", Seed("does not read", "fuse_werr_note1_d0", "fuse_werr1"), PARTED,
         "an error counts as an answer though nothing has been given up"),
    # Read for consume, consume for read
    case("branches", Seed("takes", "s_2_a", "p_running"), PARTED,
         "the first who is answered takes from p that it runs, the other is left to wait"),
    case("branches", Seed("takes", "s_3_a", "p_refusing"), PARTED,
         "the first who is refused takes the refusal, the other is left to wait"),
    case("branches", Seed("takes", "p_start0", "s_waiting_a"), PARTED,
         "a's request is gone if it starts p, not if b's does"),
    case("shared hardware", Seed("takes", "c_6_a", "c_failing"), PARTED,
         "who is told first that c fails takes it, the other is never told"),
    case("four data", Seed("takes", "fuse_werr_note1_d0", "fuse_werr1"), PARTED,
         "the note of one error forgets that fuse gives up, unless others are noted before"),
    # Kept tokens
    case("branches", Seed("keeps", "h_8", "h_release"), f"{UNSAFE} {PARTED}",
         "what is given back is given back again as soon as it is taken"),
    case("branches", Seed("ignores", "h_4", "h_failing"), f"{UNSAFE} {PARTED}",
         "whenever hardware is given back it may go out of service"),
    case("branches", Seed("ignores", "a_werr1_s", "a_wait1"), PARTED,
         "a gives up what it does not wait for"),
    case("branches", Seed("keeps", "p_sel1", "p_StartByRes"), UNSAFE, "p is started for ever"),
    case("retried", Seed("keeps", "OBJ_x_begin", "a_idle"), UNSAFE,
         "a is started before it is idle, and says twice that it is"),
    case("four data", Seed("keeps", "fuse_werr_note1_d0", "d0_error_fuse"), UNSAFE,
         "an error that has been noted stays"),
    # Dropped arcs, missing acknowledgements
    case("branches", Seed("does not put", "p_start0", "p_StartByRes"), PARTED,
         "if a's request starts p it is neither idle nor started, if b's does it runs"),
    case("four data", Seed("does not put", "fuse_werr1_d0", "fuse_werr1"), PARTED,
         "fuse leaves at one error and goes on nowhere, at another it goes on"),
    case("driver", Seed("ignores", "s_3", "s_deactivation"), f"{UNSAFE} {PARTED}",
         "a request may be refused whether the driver has refused or not"),
]  # fmt: skip

REPORTED = [
    case("branches", Seed("does not put", "s_2_a", "s_answer_a"), "success_reachable",
         "a is never answered"),
    case("branches", Seed("is missing", "s_1_a"), "success_reachable", "a request never comes"),
    case("branches", Seed("is missing", "PAR_both_exit_01"), "can_always_finish",
         "one branch has succeeded and one failed, and nothing ends the block"),
    case("shared hardware", Seed("does not put", "c_7_a", "c_answer_a"), "success_reachable",
         "shared hardware does not acknowledge that it is taken"),
    case("retried", Seed("does not put", "a_stop1", "a_idle"), "can_always_finish",
         "a that was stopped is never idle"),
    case("retried", Seed("does not put", "h_3", "h_OOS"), "can_always_finish",
         "hardware that has failed is not known to be out of service, so that a waits for it"),
]  # fmt: skip

HARMLESS = [
    case("branches", Seed("does not read", "p_refused", "s_unused_a"), "",
         "with hardware as it is, who asks p when it has left its refusal is refused again"),
    case("branches", Seed("does not read", "p_go1", "h_answer"), "",
         "h is available, so it answers in the same reaction, and nobody sees p run before"),
    case("branches", Seed("fires with", "a_err1_s", "", "s_1_a"), "",
         "a has no other alternative: whether p is refused before or after a asks again, a is refused"),
    case("branches", Seed("fires with", "p_stop1", "", "s_1_a"), "",
         "nobody asks in a reaction in which somebody gives back"),
    case("shared hardware", Seed("does not read", "c_7_a", "c_free"), "",
         "who asks has read that c is free, and nothing fails in between"),
    case("four data", Seed("does not read", "fuse_werr1_d0", "d0_error_fuse"), "",
         "at the rank of fuse all have answered, and it would run if all had what it asks for"),
]  # fmt: skip


def named(cases: list[Case]) -> list[object]:
    return [pytest.param(c, id=f"{c.of}: {getattr(c.fault, '__name__', c.fault)}") for c in cases]


def found(net: PetriNet, orders: Orders) -> str:
    """What the kernel comes to behind the events of a net."""
    trouble = settled(KernelNet(net), orders=orders, max_states=MOST).trouble
    return "" if trouble is None else trouble[2]


def of_all_markings(net: PetriNet) -> str:
    """The same of the graph of all markings, by the definition of a stable end."""
    try:
        by_reduction(explore(net, max_states=10 * MOST))
    except UnsafeError:
        return UNSAFE
    except DivergenceError:
        return ENDLESS
    except ConfluenceError:
        return PARTED
    return ""


def proved(net: PetriNet) -> bool:
    """Whether composition takes the net as one in which each event has one outcome."""
    try:
        local = explore_local(net)
    except UnsafeError:
        return False
    return local.ends and not local.conflicts


@pytest.mark.parametrize("each", named(REFUSED))
def test_a_net_with_a_fault_is_refused(each: Case) -> None:
    whole = compose(MISSIONS[each.of])
    net = each.fault(whole.net)
    for way in (found(net, "enough"), found(net, "every"), of_all_markings(net)):
        assert way in each.seen, each.why
    assert not proved(net)
    verdicts = [check(replace(whole, net=net), engine=engine) for engine in ("explicit", "symbolic")]
    for verdict in verdicts:
        failing = [name for name in verdict.failing if name != "nominal_success"]
        assert failing[0] in ("safe", "confluent")
        assert verdict.verdicts[failing[0]].runs


@pytest.mark.parametrize("each", named(REPORTED))
def test_a_fault_with_one_outcome_shows_in_a_verdict(each: Case) -> None:
    whole = compose(MISSIONS[each.of])
    net = each.fault(whole.net)
    assert (found(net, "enough"), found(net, "every"), of_all_markings(net)) == ("", "", "")
    assert not check(whole).failing
    for engine in ("explicit", "symbolic"):
        failing = {*check(replace(whole, net=net), engine=engine).failing} - {"nominal_success"}
        assert failing == each.seen, each.why


@pytest.mark.parametrize("each", named(HARMLESS))
def test_a_fault_that_changes_nothing_is_let_pass(each: Case) -> None:
    net = compose(MISSIONS[each.of]).net
    changed = each.fault(net)
    assert (found(changed, "enough"), found(changed, "every"), of_all_markings(changed)) == ("", "", "")
    before, after = direct(net), direct(changed)
    assert np.array_equal(before.markings, after.markings), each.why
    assert np.array_equal(before.offsets, after.offsets)
    assert np.array_equal(before.targets, after.targets)


def test_the_missions_themselves_are_proved() -> None:
    for of in MISSIONS.values():
        net = compose(of).net
        assert (found(net, "enough"), found(net, "every"), of_all_markings(net)) == ("", "", "")
        assert proved(net)


@given(st.data())
def test_any_single_fault_is_judged_alike(data: st.DataObject) -> None:
    """Of all faults of one arc, one rank or one transition: the proof, every order, and all markings."""
    net = compose(MISSIONS[data.draw(st.sampled_from(sorted(MISSIONS)))]).net
    fault = data.draw(st.sampled_from([*single(net)]))
    changed = fault(net)
    kind = judged_alike(changed)
    event(kind)
    event(fault.kind)
    refused = bool(of_all_markings(changed))
    assert refused == (kind != "confluent")
    assert not (proved(changed) and refused)
