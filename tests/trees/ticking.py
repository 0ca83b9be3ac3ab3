"""A small interpreter of behaviour trees, tick by tick, by the semantics of BehaviorTree.CPP 4 and Nav2.

It knows nothing of missions. Time is free: periods and timeouts may be over at any tick. A leaf that runs
answers when the one that plays says so; all choices of a tick are tried by :func:`ticks`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from mcpn.trees.nodes.forest import Forest, tree_of
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.nodes.versions import BTCPP

IDLE, RUNNING, SUCCESS, FAILURE = "idle", "running", "success", "failure"
State = tuple[tuple[str, object], ...]
"""Of each node that is not as at first, by its path, what it remembers; sorted."""
Visible = tuple[str, str]
"""A leaf that runs has answered: its name, success or failure."""
Choose = Callable[[tuple[str, ...]], str]


@dataclass
class Tree:
    """A tree whose subtrees are written out, each node with a path.

    Args:
        forest: The trees.
        quick: The names of leaves that answer at once when they are asked again, or behind others that are.
    """

    forest: Forest
    quick: frozenset[str]
    state: dict[str, object] = field(default_factory=dict)
    answers: dict[str, str] = field(default_factory=dict)
    seen: list[Visible] = field(default_factory=list)
    answered: list[Visible] = field(default_factory=list)
    choose: Choose = lambda options: options[0]
    leaves: dict[str, TreeNode] = field(default_factory=dict)

    def tick(self, node: TreeNode, at: str, again: bool) -> str:
        """Ticks a node. ``again``: a later sibling of it, or of something around it, runs."""
        tree = tree_of(self.forest, node)
        status = self.tick(tree.root, f"{at}/", again) if tree else self._tick(node, at, again)
        self.set(at, "status", status)
        return status

    def _tick(self, node: TreeNode, at: str, again: bool) -> str:
        if not node.children and node.id not in ("Script", "AlwaysSuccess", "AlwaysFailure"):
            return self.leaf(node, at, again)
        method = getattr(self, "tick" + re.sub("([A-Z])", r"_\1", node.id).lower())
        return str(method(node, at, again))

    def leaf(self, node: TreeNode, at: str, again: bool) -> str:
        self.leaves[at] = node
        quick = node.id in self.quick
        if self.get(at, "status", IDLE) == RUNNING:
            answer = self.answers.get(at, RUNNING)
        elif quick and again:
            answer = self.choose((SUCCESS, FAILURE))
        else:
            answer = self.choose((RUNNING, SUCCESS, FAILURE))
        if answer != RUNNING and not quick:
            self.seen.append((node.id, answer))
            self.answered.append((node.id, answer))
        return answer

    def at_once(self, node: TreeNode) -> bool:
        """Whether all leaves below answer at once when they are asked again."""
        trees = [node if tree is None else tree.root for tree in (tree_of(self.forest, node),)]
        inner = [n for root in trees for n in root.walk() if not n.children]
        return all(n.id in (*self.quick, "Script", "AlwaysSuccess", "AlwaysFailure") for n in inner)

    def returns(self) -> bool:
        """Whether a node returns between its children or rounds: it may be interrupted then, since 4.0."""
        since_4 = all(version.startswith("4.") for version in self.forest.choice.allowed[BTCPP])
        return since_4 or self.choose((RUNNING, "on")) == RUNNING

    def get(self, at: str, what: str, default: object) -> object:
        return self.state.get(f"{at}:{what}", default)

    def count(self, at: str, what: str) -> int:
        return int(str(self.get(at, what, 0)))

    def set(self, at: str, what: str, value: object) -> None:
        if value in (IDLE, 0, ()):
            self.state.pop(f"{at}:{what}", None)
        else:
            self.state[f"{at}:{what}"] = value

    def child(self, node: TreeNode, at: str, number: int, again: bool) -> str:
        return self.tick(node.children[number], f"{at}.{number}", again)

    def runs(self, at: str, number: int) -> bool:
        return self.get(f"{at}.{number}", "status", IDLE) == RUNNING

    def halt_child(self, node: TreeNode, at: str, number: int) -> None:
        """Halts a child that runs; its status is idle then, whatever it was."""
        child, place = node.children[number], f"{at}.{number}"
        if self.get(place, "status", IDLE) == RUNNING:
            self.halt(child, place)
        self.set(place, "status", IDLE)

    def reset_children(self, node: TreeNode, at: str) -> None:
        for number in range(len(node.children)):
            self.halt_child(node, at, number)

    def halt(self, node: TreeNode, at: str) -> None:
        tree = tree_of(self.forest, node)
        if tree is not None:
            if self.get(f"{at}/", "status", IDLE) == RUNNING:
                self.halt(tree.root, f"{at}/")
            self.set(f"{at}/", "status", IDLE)
            return
        if node.id not in ("SequenceWithMemory",):
            for what in ("index", "tries", "done", "failed", "begun"):
                self.set(at, what, 0)
        self.reset_children(node, at)

    def _series(self, node: TreeNode, at: str, again: bool, stops: str) -> str:
        while (index := self.count(at, "index")) < len(node.children):
            status = self.child(node, at, index, again)
            if status == RUNNING:
                return RUNNING
            if status == stops:
                self.reset_children(node, at)
                self.set(at, "index", 0)
                return stops
            self.set(at, "index", index + 1)
        self.reset_children(node, at)
        self.set(at, "index", 0)
        return SUCCESS if stops == FAILURE else FAILURE

    def tick_sequence(self, node: TreeNode, at: str, again: bool) -> str:
        return self._series(node, at, again, FAILURE)

    def tick_fallback(self, node: TreeNode, at: str, again: bool) -> str:
        return self._series(node, at, again, SUCCESS)

    def _async_series(self, node: TreeNode, at: str, again: bool, stops: str) -> str:
        while (index := self.count(at, "index")) < len(node.children):
            began = not self.runs(at, index)
            status = self.child(node, at, index, again)
            if status == RUNNING:
                return RUNNING
            self.set(at, "index", index + 1)
            if status == stops or index + 1 == len(node.children):
                self.halt(node, at)
                return status
            if began:
                return RUNNING
        raise AssertionError(at)

    def tick_async_sequence(self, node: TreeNode, at: str, again: bool) -> str:
        return self._async_series(node, at, again, FAILURE)

    def tick_async_fallback(self, node: TreeNode, at: str, again: bool) -> str:
        return self._async_series(node, at, again, SUCCESS)

    def tick_sequence_with_memory(self, node: TreeNode, at: str, again: bool) -> str:
        while (index := self.count(at, "index")) < len(node.children):
            began = not self.runs(at, index)
            status = self.child(node, at, index, again)
            if status == RUNNING:
                return RUNNING
            if status == FAILURE:
                for number in range(index, len(node.children)):
                    self.halt_child(node, at, number)
                return FAILURE
            self.set(at, "index", index + 1)
            if began and index + 1 < len(node.children) and self.returns():
                return RUNNING
        self.reset_children(node, at)
        self.set(at, "index", 0)
        return SUCCESS

    def _reactive(self, node: TreeNode, at: str, again: bool, stops: str) -> str:
        for number in range(len(node.children)):
            later = any(self.runs(at, n) for n in range(number + 1, len(node.children)))
            quick = (later or number > 0) and self.at_once(node.children[number])
            before = len(self.seen)
            status = self.child(node, at, number, again or quick)
            if later and status not in (RUNNING, stops):
                del self.seen[before:]  # asked again, it has answered at once, as a condition does
            if status == RUNNING:
                for other in range(len(node.children)):
                    if other != number:
                        self.halt_child(node, at, other)
                return RUNNING
            if status == stops:
                self.reset_children(node, at)
                return stops
        self.reset_children(node, at)
        return SUCCESS if stops == FAILURE else FAILURE

    def tick_reactive_sequence(self, node: TreeNode, at: str, again: bool) -> str:
        return self._reactive(node, at, again, FAILURE)

    def tick_reactive_fallback(self, node: TreeNode, at: str, again: bool) -> str:
        return self._reactive(node, at, again, SUCCESS)

    def tick_if_then_else(self, node: TreeNode, at: str, again: bool) -> str:
        index = self.count(at, "index")
        if index == 0:
            kept = self.get(f"{at}.0", "status", IDLE) == FAILURE and not self.at_once(node.children[0])
            # Without a third child it returns without resetting the first, and an action keeps its answer.
            status = FAILURE if kept and not node.children[0].children else self.child(node, at, 0, again)
            if status == RUNNING:
                return RUNNING
            index = 1 if status == SUCCESS else 2
            if index == len(node.children):
                return FAILURE
            self.set(at, "index", index)
        status = self.child(node, at, index, again)
        if status != RUNNING:
            self.reset_children(node, at)
            self.set(at, "index", 0)
        return status

    def tick_while_do_else(self, node: TreeNode, at: str, again: bool) -> str:
        later = any(self.runs(at, n) for n in range(1, len(node.children)))
        asked = self.child(node, at, 0, again or (later and self.at_once(node.children[0])))
        if asked == RUNNING:
            return RUNNING
        chosen, other = (1, 2) if asked == SUCCESS else (2, 1)
        if len(node.children) == 3:
            self.halt_child(node, at, other)
        if chosen == len(node.children):
            status = FAILURE
        else:
            quick = self.at_once(node.children[chosen])
            status = self.child(node, at, chosen, again or quick)
        if status != RUNNING:
            self.reset_children(node, at)
        return status

    def tick_try_catch(self, node: TreeNode, at: str, again: bool) -> str:
        last = len(node.children) - 1
        while not self.get(at, "done", 0) and (index := self.count(at, "index")) < last:
            status = self.child(node, at, index, again)
            if status == RUNNING:
                return RUNNING
            if status == FAILURE:
                self.reset_children(node, at)
                self.set(at, "done", 1)
            else:
                self.set(at, "index", index + 1)
        caught = bool(self.get(at, "done", 0))
        if caught and self.child(node, at, last, again) == RUNNING:
            return RUNNING
        self.reset_children(node, at)
        self.set(at, "index", 0)
        self.set(at, "done", 0)
        return FAILURE if caught else SUCCESS

    def tick_parallel(self, node: TreeNode, at: str, again: bool) -> str:
        count = len(node.children)
        wanted, allowed = (
            int(node.ports.get("success_count", "-1")),
            int(node.ports.get("failure_count", "1")),
        )
        wanted = count + wanted + 1 if wanted < 0 else wanted
        allowed = count + allowed + 1 if allowed < 0 else allowed
        done = dict(self.get(at, "done", ()))  # type: ignore[call-overload]
        for number in range(count):
            if number not in done and (status := self.child(node, at, number, again)) != RUNNING:
                done[number] = status
            good, bad = [*done.values()].count(SUCCESS), [*done.values()].count(FAILURE)
            if good >= wanted or count - bad < wanted or bad == allowed:
                self.reset_children(node, at)
                self.set(at, "done", 0)
                return SUCCESS if good >= wanted else FAILURE
        self.set(at, "done", tuple(sorted(done.items())))
        return RUNNING

    def tick_parallel_all(self, node: TreeNode, at: str, again: bool) -> str:
        count, allowed = len(node.children), int(node.ports.get("max_failures", "1"))
        allowed = count + allowed + 1 if allowed < 0 else allowed
        done = dict(self.get(at, "done", ()))  # type: ignore[call-overload]
        for number in range(count):
            if number not in done and (status := self.child(node, at, number, again)) != RUNNING:
                done[number] = status
        if len(done) < count:
            self.set(at, "done", tuple(sorted(done.items())))
            return RUNNING
        self.reset_children(node, at)
        self.set(at, "done", 0)
        return FAILURE if [*done.values()].count(FAILURE) >= allowed else SUCCESS

    def _turned(self, node: TreeNode, at: str, again: bool, means: dict[str, str]) -> str:
        status = self.child(node, at, 0, again)
        if status != RUNNING:
            self.halt_child(node, at, 0)
        return means.get(status, status)

    def tick_inverter(self, node: TreeNode, at: str, again: bool) -> str:
        return self._turned(node, at, again, {SUCCESS: FAILURE, FAILURE: SUCCESS})

    def tick_force_success(self, node: TreeNode, at: str, again: bool) -> str:
        return self._turned(node, at, again, {FAILURE: SUCCESS})

    def tick_force_failure(self, node: TreeNode, at: str, again: bool) -> str:
        return self._turned(node, at, again, {SUCCESS: FAILURE})

    def _loop(self, node: TreeNode, at: str, again: bool, times: int, goes_on: str) -> str:
        for rounds in range(50):
            if times != -1 and self.count(at, "tries") >= times:
                break
            began = not self.runs(at, 0)
            status = self.child(node, at, 0, again)
            if status == RUNNING:
                return RUNNING
            self.halt_child(node, at, 0)
            if status != goes_on:
                self.set(at, "tries", 0)
                return status
            if times != -1:
                self.set(at, "tries", self.count(at, "tries") + 1)
            ends = times != -1 and self.count(at, "tries") >= times
            # Where it need not return, two rounds in one tick show all that more of them would.
            if not ends and began and (rounds > 0 or self.returns()):
                return RUNNING
        else:
            return RUNNING
        self.set(at, "tries", 0)
        return goes_on

    def tick_retry_until_successful(self, node: TreeNode, at: str, again: bool) -> str:
        return self._loop(node, at, again, int(node.ports["num_attempts"]), FAILURE)

    def tick_repeat(self, node: TreeNode, at: str, again: bool) -> str:
        return self._loop(node, at, again, int(node.ports["num_cycles"]), SUCCESS)

    def tick_keep_running_until_failure(self, node: TreeNode, at: str, again: bool) -> str:
        return self._turned(node, at, again, {SUCCESS: RUNNING})

    def tick_loop_int(self, node: TreeNode, at: str, again: bool) -> str:
        if not self.runs(at, 0):
            if self.count(at, "tries") == len(node.ports["queue"].split(";")):
                self.set(at, "tries", 0)
                return node.ports.get("if_empty", "SUCCESS").lower()
            self.set(at, "tries", self.count(at, "tries") + 1)
        status = self.child(node, at, 0, again)
        if status != RUNNING:
            self.halt_child(node, at, 0)
        if status == FAILURE:
            self.set(at, "tries", 0)
        return FAILURE if status == FAILURE else RUNNING

    def tick_timeout(self, node: TreeNode, at: str, again: bool) -> str:
        timed = node.ports.get("msec", "").strip() != "0"  # which sets no timer
        if timed and self.runs(at, 0) and self.choose(("in time", "over")) == "over":
            self.halt_child(node, at, 0)
            return FAILURE
        return self._turned(node, at, again, {})

    def tick_delay(self, node: TreeNode, at: str, again: bool) -> str:
        if not self.get(at, "begun", 0):
            if self.choose(("wait", "over")) == "wait":
                return RUNNING
            self.set(at, "begun", 1)
        status = self._turned(node, at, again, {})
        if status != RUNNING:
            self.set(at, "begun", 0)
        return status

    def tick_script(self, node: TreeNode, at: str, again: bool) -> str:
        return SUCCESS

    tick_always_success = tick_script

    def tick_always_failure(self, node: TreeNode, at: str, again: bool) -> str:
        return FAILURE

    def tick_recovery_node(self, node: TreeNode, at: str, again: bool) -> str:
        times = int(node.ports.get("number_of_retries", "1"))

        def ended(status: str) -> str:
            self.halt(node, at)
            return status

        while True:
            if not self.get(at, "index", 0):
                status = self.child(node, at, 0, again)
                if status == FAILURE and self.count(at, "tries") < times:
                    self.halt_child(node, at, 0)
                    self.set(at, "index", 1)
                    continue
                return RUNNING if status == RUNNING else ended(status)
            status = self.child(node, at, 1, again)
            if status != SUCCESS:
                return RUNNING if status == RUNNING else ended(status)
            self.halt_child(node, at, 1)
            self.set(at, "tries", self.count(at, "tries") + 1)
            self.set(at, "index", 0)

    def tick_round_robin(self, node: TreeNode, at: str, again: bool) -> str:
        count = len(node.children)
        since_1_5 = self.forest.choice.allowed["nav2"] == frozenset({"1.5"})
        wraps = not since_1_5 or node.ports.get("wrap_around", "false") == "true"
        while self.count(at, "failed") < count:
            index = self.count(at, "index")
            status = self.child(node, at, index, again)
            if status == RUNNING:
                return RUNNING
            self.set(at, "index", (index + 1) % count)
            if index + 1 == count and not wraps:
                break  # before it is looked whether it has succeeded
            if status == SUCCESS:
                self.set(at, "failed", 0)
                self.reset_children(node, at)
                return SUCCESS
            self.set(at, "failed", self.count(at, "failed") + 1)
        self.halt(node, at)
        return FAILURE

    def tick_pipeline_sequence(self, node: TreeNode, at: str, again: bool) -> str:
        for number in range(len(node.children)):
            last = self.count(at, "index")
            status = self.child(
                node, at, number, again or (number < last and self.at_once(node.children[number]))
            )
            if status == FAILURE:
                self.reset_children(node, at)
                self.set(at, "index", 0)
                return FAILURE
            if status == RUNNING and number >= last:
                self.set(at, "index", number)
                return RUNNING
        self.reset_children(node, at)
        self.set(at, "index", 0)
        return SUCCESS

    def tick_rate_controller(self, node: TreeNode, at: str, again: bool) -> str:
        first = self.get(at, "status", IDLE) == IDLE
        if not first and not self.runs(at, 0) and self.choose(("wait", "over")) == "wait":
            return RUNNING
        return self._turned(node, at, again, {})


def ticks(tree: Tree, state: State) -> Iterator[tuple[State, str, tuple[Visible, ...], tuple[Visible, ...]]]:
    """All that one tick may do: at most one leaf that runs ends of itself.

    Yields:
        The state after it, what the root returned, which leaves have answered, and all that did so: with
        those that answer, asked again, as a condition does.
    """
    root = tree.forest.main.root
    running = [k.removesuffix(":status") for k, v in state if k.endswith(":status") and v == RUNNING]
    ending: list[dict[str, str]] = [{}]
    ending += [{at: end} for at in running if at in tree.leaves for end in (SUCCESS, FAILURE)]
    found = set()
    for answers in ending:
        stack: list[list[int]] = [[]]
        while stack:
            script = stack.pop()
            asked: list[tuple[str, ...]] = []

            tree.state, tree.seen, tree.answered, tree.answers = dict(state), [], [], answers
            tree.choose = _choosing(script, asked)
            status = tree.tick(root, "", False)
            for place in range(len(script), len(asked)):
                taken = script + [0] * (place - len(script))
                stack += [[*taken, other] for other in range(1, len(asked[place]))]
            after = tuple(sorted(tree.state.items(), key=lambda item: item[0]))
            found.add((after, status, tuple(tree.seen), tuple(tree.answered)))
    yield from sorted(found, key=repr)


def _choosing(script: list[int], asked: list[tuple[str, ...]]) -> Choose:
    """Chooses as a script says, then the first of what there is; what was asked is kept."""

    def choose(options: tuple[str, ...]) -> str:
        asked.append(options)
        place = len(asked) - 1
        return options[script[place]] if place < len(script) else options[0]

    return choose
