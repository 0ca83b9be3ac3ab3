"""The faults that ``seeded_faults.py`` seeds: by area, in which file, what is wrong, old text and new."""

from __future__ import annotations

from typing import NamedTuple


class Seeded(NamedTuple):
    """One fault.

    Args:
        area: The part of mcpn.
        path: The file, in the package.
        wrong: What is wrong.
        old: Text that stands once in that file.
        new: What stands there instead.
        asks: What may show it, as mission, question and how.
    """

    area: str
    path: str
    wrong: str
    old: str
    new: str
    asks: tuple[str, ...]

    @property
    def name(self) -> str:
        """How it is called."""
        return f"{self.area}: {self.wrong}"


CHECKS = (
    "ulysse check explicit",
    "survey check explicit",
    "ends check explicit",
    "happens once inside check explicit",
)
LOCAL = ("survey check local", "happens once inside check local", "retried check local", "ulysse check local")
CAUSES = (
    "survey causes explicit",
    "ulysse causes explicit",
    "branches causes explicit",
    "happens once inside causes explicit",
)
LOSSES = ("survey causes local", "branches causes local", "happens once inside causes local")
RISKS = ("survey risk explicit", "survey risk local")
TABLES = ("ulysse controller hierarchical", "survey controller hierarchical", "facts controller hierarchical")
LISTED = (*TABLES, "happens once inside controller hierarchical", "survey controller flat")
SMALL = ("survey controller minimised", "found late controller minimised", "facts controller minimised")
SMALLER = (
    *SMALL,
    "happens once inside controller minimised",
    "branches controller minimised",
    "ulysse controller minimised",
)
RULES = ("survey controller modular", "happens once inside controller modular", "branches controller modular")
_T, _B, _C, _K = "templates", "big steps", "composition", "causes"
_M, _D, _R = "minimiser", "controller", "risk"
_STEPS = "spaces/stable/big_steps.py"
_TYPE, _GLUED = "composite/section_type.py", "composite/glued.py"
_CUTS, _PROSPECTS = "answers/causes/minimal_cut_sets.py", "answers/causes/prospects.py"
_MINIMISE, _DOCUMENT, _MACHINE = "controller/minimise.py", "controller/document.py", "controller/machine.py"
_CHAIN, _RISK, _WHOLE = "answers/causes/chain.py", "answers/causes/risk.py", "answers/causes/whole_chain.py"

ENDS_AT_ONE_MOMENT = Seeded(
    _T,
    "drawing/templates/ranks.py",
    "ends at one moment: blocks are decided from outside in",
    "for level in reversed(levels) for branch in level",
    "for level in levels for branch in level",
    ("ends check explicit",),
)
"""What the commit "What ends at one moment counts together, at whatever depth" has mended."""

FAULTS: tuple[Seeded, ...] = (
    ENDS_AT_ONE_MOMENT,
    Seeded(
        _T,
        "drawing/templates/leaving.py",
        "a block is decided and the branches that have decided it are halted again",
        "for b in section.branches if b not in those]",
        "for b in section.branches]",
        ("ends check explicit", "counts failures check explicit"),
    ),
    Seeded(
        _T,
        "drawing/templates/leaving.py",
        "optional children make a wide block fail",
        'outcome = "success" if counted == needed else "failure"',
        'outcome = "failure"',
        ("counts failures check explicit", "ends before all check explicit"),
    ),
    Seeded(
        _T,
        "drawing/templates/resources.py",
        "hardware that is shared and repaired is not free again",
        'pen.transition("EV_RD", [oos], [free, *every, *watched], event=returns)',
        'pen.transition("EV_RD", [oos], [*every, *watched], event=returns)',
        ("shared hardware check explicit",),
    ),
    Seeded(
        _T,
        "drawing/templates/resources.py",
        "a producer is never answered for",
        'pen.transition("3", [waiting, deactivation], [deactivation, error])',
        'pen.transition("3", [waiting, deactivation], [deactivation, answer, busy])',
        ("survey check explicit", "ulysse check explicit"),
    ),
    Seeded(
        _B,
        "spaces/stable/run_to_completion.py",
        "confluence is asked of one order alone",
        'exploration = settled(prepared, orders="enough", max_states=max_states, max_firings=max_firings)',
        'exploration = settled(prepared, orders="one", max_states=max_states, max_firings=max_firings)',
        ("clash check explicit",),
    ),
    Seeded(
        _B,
        _STEPS,
        "what an event leads to is not reached",
        "return fresh.images(self._ahead.get(t, []))",
        "return fresh",
        LOCAL,
    ),
    Seeded(_B, _STEPS, "one round finds all", "while reached != begun:", "for _ in range(1):", LOCAL),
    Seeded(
        _B,
        _STEPS,
        "events with a guard happen without it",
        "free = {t: events[t] for t in asked if not guards or t not in guards}",
        "free = {t: events[t] for t in asked}",
        (*LOSSES, *LOCAL),
    ),
    Seeded(
        _B,
        _STEPS,
        "all events are asked for",
        "asked = [t for t in events if transitions is None or t in transitions]",
        "asked = list(events)",
        (*LOSSES, *LOCAL),
    ),
    Seeded(
        _B,
        _STEPS,
        "runs leave the set that they are to stay in",
        "return [lambda states: states.saturate(few, within=along), *each, *some]",
        "return [lambda states: states.saturate(few), *each, *some]",
        (*LOSSES, *LOCAL),
    ),
    Seeded(
        _B,
        _STEPS,
        "runs back stop after one kind of step",
        "return [lambda states: states.saturate(few, within=along | states), *each, *some]",
        "return [*each, *some]",
        (*LOCAL, *LOSSES),
    ),
    Seeded(
        _B,
        "composite/explored_section.py",
        "what is lost for good is repaired",
        "also = {t: encoding.levels(p for p in safe[t].read if p >= first) for t in steps}",
        "also = {t: [] for t in steps}",
        LOSSES,
    ),
    Seeded(
        _B,
        "composite/explored_section.py",
        "nothing is lost for good",
        "stable = stable.images([all_alive]).saturate([events[t] for t in losses.values()])",
        "stable = stable.images([all_alive])",
        LOSSES,
    ),
    Seeded(
        _C,
        _TYPE,
        "a section that is left hands on hardware in service",
        "[event(gained, [slot, *lost])]",
        "[event(gained, lost)]",
        (*LOCAL, *LOSSES),
    ),
    Seeded(
        _C,
        _TYPE,
        "no hardware fails beside a section",
        "beside = [toggle.event for toggle in self.layout.toggling(allowed.beside)]",
        "beside = list[int]()",
        (*LOCAL, *LOSSES),
    ),
    Seeded(
        _C,
        _TYPE,
        "no hardware is repaired on the way back",
        "beside = [toggle.undo for toggle in self.layout.toggling(allowed.beside)]",
        "beside = list[int]()",
        (*LOSSES, *LOCAL),
    ),
    Seeded(
        _C,
        _TYPE,
        "states after a section count as its own",
        "            self.inside -= states",
        "            self.inside -= states - states",
        LOCAL,
    ),
    Seeded(
        _C,
        _TYPE,
        "an exit needs no place to be marked but one",
        "return [len(t.consume) + len(t.read) for t in self.net.net.safe_transitions]",
        "return [len(t.consume) + len(t.read) + 1 for t in self.net.net.safe_transitions]",
        LOCAL,
    ),
    Seeded(
        _C,
        "composite/leaving_out.py",
        "every section on the way can be passed by",
        "if not at or self._nearest[at[-1]] < at[0]:",
        "if not at or self._nearest[at[-1]] <= at[0]:",
        LOCAL,
    ),
    Seeded(
        _C,
        "composite/leaving_out.py",
        "no exit leads on",
        "return stage.type.may_lead_to(own).isdisjoint(onward)",
        "return not stage.type.may_lead_to(own).isdisjoint(onward)",
        LOCAL,
    ),
    Seeded(
        _C,
        _GLUED,
        "what is entered is not followed",
        "return (route for route, states in entering.items() if targets.add(route, states))",
        "return (route for route, states in entering.items() if not targets.add(route, states))",
        LOCAL,
    ),
    Seeded(
        _C,
        _GLUED,
        "one step stays in its section",
        "targets = self.entering(parts, self.everything, allowed)",
        "targets = SectionSets()",
        (*LOCAL, *LOSSES),
    ),
    Seeded(
        _C,
        _GLUED,
        "a maximal run may leave a section whose exits lead out of the set",
        "onward = ends.of(name) | stage.type.before_step(self.ends_into(stage, remaining), own)",
        "onward = part",
        LOCAL,
    ),
    Seeded(
        _C,
        "composite/sections.py",
        "failure and abort are one for the other",
        'routes = {"success": SUCCEED, "failure": FAIL, "abort": ABORT}',
        'routes = {"success": SUCCEED, "failure": ABORT, "abort": FAIL}',
        (*LOCAL, *LOSSES),
    ),
    Seeded(
        _K,
        _CUTS,
        "the last minimal cut set is left out",
        "return sorted(names, key=lambda members: (len(members), members))",
        "return sorted(names, key=lambda members: (len(members), members))[:-1]",
        CAUSES,
    ),
    Seeded(
        _K,
        _CUTS,
        "lost at the start: nothing is repaired afterwards",
        "return self.space.reached(before, transitions=self.everything)",
        "return self.space.reached(before, transitions=self.unrepaired)",
        CAUSES,
    ),
    Seeded(
        _K,
        _CUTS,
        "lost at the entry: survived wherever the objective runs",
        "survived = self.entered(section) & goal.running & hopeful",
        "survived = goal.running & hopeful",
        CAUSES,
    ),
    Seeded(
        _K,
        _CUTS,
        "lost whenever: asked at the start alone",
        "        else:\n            survived = goal.running & hopeful",
        "        else:\n            survived = goal.running & hopeful & self.space.initial",
        CAUSES,
    ),
    Seeded(
        _K,
        _CUTS,
        "lost at the worst moment: objectives fail as they like before",
        "found = space.reached(space.initial, transitions=transitions, guards=self.forced)",
        "found = space.reached(space.initial, transitions=transitions)",
        CAUSES,
    ),
    Seeded(
        _K,
        _CUTS,
        "lost at the worst moment: what is out may be repaired",
        "return found - space.enabling(self.dying)",
        "return found",
        CAUSES,
    ),
    Seeded(
        _K,
        _CUTS,
        "lost at the worst moment: a mission that has failed counts",
        "return self._dead((goal.running & self._at_worst) - hopeful - self._failed(goal))",
        "return self._dead((goal.running & self._at_worst) - hopeful)",
        CAUSES,
    ),
    Seeded(
        _K,
        _PROSPECTS,
        "a run to an objective's success goes on after its end",
        "return Without(self.everything if repairs else self.unrepaired, goal.ends)",
        "return Without(self.everything if repairs else self.unrepaired, frozenset())",
        CAUSES,
    ),
    Seeded(
        _K,
        _PROSPECTS,
        "nothing fails as a section is entered",
        "return space.reached(entry, transitions=self.failing | self.dying)",
        "return entry",
        CAUSES,
    ),
    Seeded(
        _K,
        _PROSPECTS,
        "states in which a goal is lost are those in which it is open",
        "return goal.running - self.hopeful(goal, repairs=repairs)",
        "return goal.running & self.hopeful(goal, repairs=repairs)",
        CAUSES,
    ),
    Seeded(
        _K,
        "answers/causes/find.py",
        "one loss more is survived, whichever it is",
        "always = len(cut_sets[0]) - 1 if cut_sets else len(cuts.hardware)",
        "always = len(cut_sets[0]) if cut_sets else len(cuts.hardware)",
        CAUSES,
    ),
    Seeded(
        _M,
        _MINIMISE,
        "actions tell no states apart",
        "                        m.actions,\n",
        "",
        SMALLER,
    ),
    Seeded(
        _M,
        _MINIMISE,
        "where edges lead tells no states apart",
        "classes[m.target] if isinstance(m.target, int) else m.target,\n                    )\n",
        "None if isinstance(m.target, int) else m.target,\n                    )\n",
        SMALLER,
    ),
    Seeded(_M, _MINIMISE, "one round refines enough", "if finer == classes:", "if finer:", SMALLER),
    Seeded(
        _M,
        _MINIMISE,
        "what is out of service tells no states apart",
        "        state.out_of_service,\n",
        "",
        SMALLER,
    ),
    Seeded(
        _M, _MINIMISE, "the mode tells no states apart", "        tuple(state.mode.items()),\n", "", SMALLER
    ),
    Seeded(_M, _MINIMISE, "facts are forgotten", "                        m.gained,\n", "", SMALLER),
    Seeded(
        _M,
        _MINIMISE,
        "an edge leads to the first state of all",
        "target=classes[m.target] if isinstance(m.target, int) else m.target,\n            )",
        "target=0 if isinstance(m.target, int) else m.target,\n            )",
        SMALLER,
    ),
    Seeded(
        _M,
        "controller/reduce.py",
        "rules keep what enables them, and nothing that tells them apart",
        "            yield (*chosen, *kept)",
        "            yield (*kept,)",
        RULES,
    ),
    Seeded(
        _M,
        "controller/reduce.py",
        "a bit that only rules read is dropped",
        "bits = set(spoken).union(literal >> 1 for _, literals, _, _ in shorter for literal in literals)",
        "bits = set(spoken)",
        RULES,
    ),
    Seeded(
        _D,
        _MACHINE,
        "hardware is not released",
        'yield from (PlannedAction("release", hardware=k) for k in dict.fromkeys(released))',
        "",
        LISTED,
    ),
    Seeded(
        _D,
        _MACHINE,
        "what is consumed is stopped first",
        'yield from (PlannedAction("stop", a) for a in first if a in stopped)',
        'yield from (PlannedAction("stop", a) for a in first[::-1] if a in stopped)',
        LISTED,
    ),
    Seeded(
        _D,
        _MACHINE,
        "what consumes is started first",
        "a for a in self._order(after, after.mode)[::-1] if a not in before.mode or a in changed | stopped",
        "a for a in self._order(after, after.mode) if a not in before.mode or a in changed | stopped",
        LISTED,
    ),
    Seeded(
        _D,
        _MACHINE,
        "no timer is disarmed",
        'yield from (PlannedAction("disarm", objective=o) for o in was if o in passage.ended)',
        "",
        LISTED,
    ),
    Seeded(
        _D,
        _DOCUMENT,
        "handlers that happen once happen again",
        '"open": list(guard.open),',
        '"open": [],',
        ("survey controller hierarchical", "happens once inside controller hierarchical"),
    ),
    Seeded(
        _D,
        _DOCUMENT,
        "what becomes true of facts is said to be false",
        '            "gained": list(gained),\n',
        '            "gained": list(lost),\n',
        ("facts controller hierarchical", "guarded and recovered controller hierarchical"),
    ),
    Seeded(
        _D,
        _DOCUMENT,
        "the entry of a section orders nothing",
        '"actions": [_action(a) for a in entry.actions],',
        '"actions": [],',
        LISTED,
    ),
    Seeded(
        _D,
        _DOCUMENT,
        "what is never repaired is not said",
        '"unrepairable": [h.name for h in hardware if not h.repairable],',
        '"unrepairable": [],',
        LISTED,
    ),
    Seeded(
        _D,
        _DOCUMENT,
        "requirements are not said",
        '        "requirements": _requirements(mission_net),',
        '        "requirements": [],',
        LISTED,
    ),
    Seeded(
        _D,
        _DOCUMENT,
        "an objective's time is that of no objective",
        '                "timeout": section.timeout,',
        '                "timeout": None,',
        LISTED,
    ),
    Seeded(
        _D,
        "controller/hierarchy.py",
        "sections of one type keep the names of the first",
        "own = tuple(_renamed(event, names) for event in events[placed.type])",
        "own = events[placed.type]",
        LISTED,
    ),
    Seeded(
        _R,
        _RISK,
        "failure and repair are one for the other",
        '("hardware", h): (hardware[h].failure_rate or 0.0, hardware[h].repair_rate or 0.0)',
        '("hardware", h): (hardware[h].repair_rate or 0.0, hardware[h].failure_rate or 0.0)',
        RISKS,
    ),
    Seeded(
        _R,
        _RISK,
        "a resource is worth what is left without it",
        "best, worst = frozen.ends(kept=resource), frozen.ends(resource)",
        "best, worst = ends, frozen.ends(resource)",
        RISKS,
    ),
    Seeded(
        _R,
        _WHOLE,
        "what is proved has no repairs",
        "each = ((known[name].failure_rate or 0.0, known[name].repair_rate or 0.0) for name in hardware)",
        "each = ((known[name].failure_rate or 0.0, 0.0) for name in hardware)",
        RISKS,
    ),
    Seeded(
        _R,
        _CHAIN,
        "an objective succeeds as often as it ends",
        "self.rates[well] = rate * (1 - sum(failures))",
        "self.rates[well] = rate",
        RISKS,
    ),
    Seeded(
        _R,
        _CHAIN,
        "what cannot succeed any more runs on",
        "failed |= badly & (running & ~hopeful)[sources]",
        "failed |= badly & False",
        RISKS,
    ),
    Seeded(
        _R,
        _CHAIN,
        "declared events never happen",
        "self.occurring.append(rate or 0.0)",
        "self.occurring.append(0.0)",
        RISKS,
    ),
    Seeded(
        _R,
        "answers/causes/section_chains.py",
        "sections last their rate",
        "(1.0 / o.duration if o.duration else 0.0, *o.shares)",
        "(o.duration if o.duration else 0.0, *o.shares)",
        ("survey risk local", "survey risk explicit"),
    ),
    Seeded(
        _R,
        "answers/causes/interval_bounds.py",
        "what is proved begins in another state",
        "return np.where(better == up, high.rates, low.rates).astype(np.float64)",
        "return np.where(better == up, high.rates, low.rates).astype(np.float64) * 0 + 1.0",
        RISKS,
    ),
)
"""All of them."""
