"""Broken missions: a located message for each, never another exception, never half a result."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.errors import InputError, LimitError, Problem
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Block, Each, Mission, Objective, Parallel, Protocol, Recursive
from mcpn.mission.rewriting.limits import MAX_NESTING
from mcpn.mission.robot import Activity, Alternative, Robot
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.validate import find_errors
from mcpn.mission.writer import write_mission
from mcpn.mission.xml import MAX_ELEMENTS, MAX_FILE_BYTES, read_mission
from tests.conftest import ULYSSE
from tests.draws import fewer

NS = 'xmlns="urn:mcpn:mission:1"'
ROBOT = """<robot name="r">
<hardware name="H"/><software name="S"/>
<activity name="driver" produces="S" consumes="H"/>
<activity name="go" consumes="S"/>
<activity name="look"/>
</robot>
"""
OK = '<objective name="o" activities="go"/>'


def body(blocks: str = OK, robot: str = ROBOT) -> str:
    """A mission whose robot starts at line 2 and whose blocks start at line 8."""
    return f'<mission name="m" {NS}>\n{robot}{blocks}\n</mission>'


def robot(inside: str, blocks: str = OK) -> str:
    """A mission with more in its robot, at line 7."""
    return body(blocks, ROBOT.replace("</robot>", f"{inside}</robot>"))


LEAK = ROBOT.replace('<hardware name="H"/>', '<hardware name="H"/><event name="leak"/>')
ON_LEAK = "<on event='leak' goto='fail'/>"
PROTOCOLS = '<protocols>\n<protocol name="p">{}</protocol>\n<protocol name="q">{}</protocol></protocols>\n'

# name: (text, line, what the message says)
BROKEN: dict[str, tuple[str, int, str]] = {
    "empty file": ("", 1, "not well-formed"),
    "blank file": ("  \n ", 2, "not well-formed"),
    "truncated": (body()[:-12], 8, "not well-formed"),
    "text, not XML": ("places and transitions", 1, "not well-formed"),
    "wrong closing tag": (body("<objective name='o' activities='go'></parallel>"), 8, "not well-formed"),
    "wrong namespace": (
        body().replace("mission:1", "mission:2"),
        1,
        "in the namespace urn:mcpn:mission:2, expected",
    ),
    "no namespace": (body().replace(NS, ""), 1, "without a namespace, expected <mission xmlns="),
    "root is a robot": (f'<robot name="r" {NS}/>', 1, "expected a mission"),
    "entity bomb": (
        '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">'
        '<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]>' + body("&c;"),
        1,
        "DTD",
    ),
    "external entity": (
        '<!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]>' + body("&x;"),
        1,
        "DTD",
    ),
    "parameter entity": (
        '<!DOCTYPE m [<!ENTITY % x SYSTEM "http://127.0.0.1/x.dtd"> %x;]>' + body(),
        1,
        "DTD",
    ),
    "external DTD": ('<!DOCTYPE mission SYSTEM "mission.dtd">' + body(), 1, "DTD"),
    "undeclared entity": (body("&nothing;"), 8, "not well-formed"),
    "unknown element": (body("<goal name='g'/>"), 8, "goal"),
    "element misspelt": (
        body("<objectiv name='g' activities='go'/>"),
        8,
        "<robot>, <translated>, <use> (did you mean objective?)",
    ),
    "attribute misspelt": (
        body("<objective name='o' activites='go'/>"),
        8,
        "recover, repeat, retries, success, timeout, timeout_goto, times (did you mean activities?)",
    ),
    "names with a comma": (
        robot("<activity name='a' consumes='S, H'/>"),
        7,
        "consumes of <activity> is 'S, H', expected names of letters, digits and _, separated by spaces",
    ),
    "unknown attribute": (body("<objective name='o' activities='go' speed='1'/>"), 8, "speed"),
    "no name": (body("<objective activities='go'/>"), 8, "name"),
    "bad name": (body("<objective name='1st' activities='go'/>"), 8, "name"),
    "name with a dot": (body("<objective name='a.b' activities='go'/>"), 8, "name"),
    "mandatory is no truth value": (
        body("<parallel name='p'>\n<objective name='o' activities='go' mandatory='maybe'/></parallel>"),
        9,
        "mandatory",
    ),
    "shared is no truth value": (robot("<hardware name='G' shared='by two'/>"), 7, "shared"),
    "exclusive is no truth value": (robot("<software name='G' exclusive='mostly'/>"), 7, "exclusive"),
    "shared software": (robot("<software name='G' shared='true'/>"), 7, "shared"),
    "exclusive hardware": (robot("<hardware name='G' exclusive='true'/>"), 7, "attribute exclusive"),
    "shared activity": (robot("<activity name='G' shared='true'/>"), 7, "attribute shared on <activity>"),
    "switch back of an alternative": (
        robot("<activity name='G'>\n<alternative name='a' switch_back='true'/></activity>"),
        8,
        "attribute switch_back on <alternative>",
    ),
    "switch_back is no truth value": (robot("<activity name='G' switch_back='soon'/>"), 7, "switch_back"),
    "switch back with one alternative": (
        robot("<activity name='G' switch_back='true'/>"),
        7,
        "one alternative: it cannot switch back",
    ),
    "faulty is no truth value": (robot("<hardware name='G' faulty='often'/>"), 7, "faulty"),
    "no blocks": (body(""), 1, "<mission> has no blocks"),
    "objective without activities": (body("<objective name='o'/>"), 8, "neither activities nor blocks"),
    "objective with activities and blocks": (
        body("<objective name='o' activities='go'>\n<objective name='x' activities='go'/></objective>"),
        8,
        "both activities and blocks",
    ),
    "timeout of no number": (
        body("<objective name='o' activities='go' timeout='soon'/>"),
        8,
        "timeout of <objective> is 'soon', expected seconds, for example 90 or 0.5, or a duration",
    ),
    "timeout in months": (
        body("<objective name='o' activities='go' timeout='P1M'/>"),
        8,
        "is 'P1M', expected",
    ),
    "timeout that ends with T": (body("<objective name='o' activities='go' timeout='P1DT'/>"), 8, "'P1DT'"),
    "timeout of nothing": (
        body("<objective name='o' activities='go' timeout='PT0S'/>"),
        8,
        "timeout of o is 0, expected from 0.001 to 2592000 seconds",
    ),
    "timeout too long": (body("<objective name='o' activities='go' timeout='P5W'/>"), 8, "is 3.024e+06"),
    "timeout_goto of a block without a timeout": (
        body(f"<parallel name='p' timeout_goto='fail'>{OK}</parallel>"),
        8,
        "p has a timeout_goto, though it has no timeout",
    ),
    "timeout_goto without a timeout": (
        body("<objective name='o' activities='go' timeout_goto='succeed'/>"),
        8,
        "o has a timeout_goto, though it has no timeout",
    ),
    "timeout_goto elsewhere": (
        body("<objective name='o' activities='go' timeout='9' timeout_goto='p'/>"),
        8,
        "timeout_goto of o leads to p; expected one of o, succeed, fail, abort",
    ),
    "timeout_goto a sibling from a branch": (
        body(
            "<parallel name='p'>\n<objective name='x' activities='go' timeout='9' timeout_goto='o'/>"
            f"{OK}</parallel>"
        ),
        9,
        "timeout_goto of x leads to o; expected one of succeed, fail, abort",
    ),
    "success_when of no number": (
        body(f"<parallel name='p' success_when='most'>{OK}</parallel>"),
        8,
        "success_when of <parallel> is 'most', expected any, all or a whole number",
    ),
    "success_when of none": (
        body(f"<parallel name='p' success_when='0'>{OK}</parallel>"),
        8,
        "success_when of p is 0, expected any, all or a whole number above 0",
    ),
    "success_when of more than there are": (
        body(f"<parallel name='p' success_when='2'>{OK}</parallel>"),
        8,
        "success_when of p is 2, though it has 1 child",
    ),
    "failure_when of more than there are": (
        body(f"<parallel name='p' failure_when='2'>{OK}</parallel>"),
        8,
        "failure_when of p is 2, though it has 1 child",
    ),
    "failure_when of none": (
        body(f"<parallel name='p' failure_when='0'>{OK}</parallel>"),
        8,
        "failure_when of p is 0, expected any, all or a whole number above 0",
    ),
    "impossible that is no word": (
        body(f"<parallel name='p' impossible='stops'>{OK}</parallel>"),
        8,
        "waits or fails",
    ),
    "success_when of an objective": (
        body("<objective name='x' activities='go' success_when='any'/>"),
        8,
        "success_when",
    ),
    "handler that leads on and pauses": (
        body(
            f"<objective name='x' activities='go'>\n<on event='leak' goto='o' pause='o'/></objective>{OK}",
            LEAK,
        ),
        9,
        "the event leak of x leads to o and pauses; expected one of goto and pause",
    ),
    "pause by nobody": (
        body(f"<objective name='x' activities='go'>\n<on event='leak' pause='y'/></objective>{OK}", LEAK),
        9,
        "pause of x on the event leak names y; expected one of o",
    ),
    "pause by an exit": (
        body("<objective name='x' activities='go'>\n<on event='leak' pause='fail'/></objective>", LEAK),
        9,
        "names fail; expected a sibling, of which there is none",
    ),
    "pause by itself": (
        body(f"<objective name='x' activities='go'>\n<on event='leak' pause='x'/></objective>{OK}", LEAK),
        9,
        "pause of x on the event leak names x; expected one of o",
    ),
    "pause of the mission": (
        body("<on event='leak' pause='o'/>\n" + OK, LEAK),
        8,
        "m pauses on the event leak, though it has no siblings: put its blocks into an objective",
    ),
    "pause of a branch": (
        body(
            "<parallel name='p'><objective name='x' activities='look'>\n"
            f"<on event='leak' pause='o'/></objective>{OK}</parallel>",
            LEAK,
        ),
        9,
        "x pauses on the event leak, though it has no siblings: put it into an objective in its branch",
    ),
    "pause by one that pauses": (
        body(
            "<objective name='x' activities='go'>\n<on event='leak' pause='o'/></objective>"
            "<objective name='o' activities='go'><on event='leak' pause='x'/></objective>",
            LEAK,
        ),
        9,
        "pause of x on the event leak runs o, which itself pauses, too: only one of them can",
    ),
    "pause by one that recovers": (
        body(
            "<objective name='x' activities='go'>\n<on event='leak' pause='y'/></objective>"
            f"<objective name='y' activities='go' recover='o'/>{OK}",
            LEAK,
        ),
        9,
        "runs y, which itself recovers by a sibling: only one of them can",
    ),
    "recover by one that pauses": (
        body(
            "<objective name='x' activities='go' recover='y'/>\n"
            f"<objective name='y' activities='go'><on event='leak' pause='o'/></objective>{OK}",
            LEAK,
        ),
        8,
        "x recovers by y, which itself pauses: only one of them can",
    ),
    "block with the name of a copy": (
        body(
            "<objective name='x' activities='go'><on event='leak' pause='o'/></objective>\n"
            f"<objective name='o_at_x' activities='go'/>{OK}",
            LEAK,
        ),
        9,
        "o_at_x could be the name of a copy of o, which is run while x pauses: rename it",
    ),
    "recover of nobody": (
        body(f"<objective name='x' activities='go' recover='back'/>{OK}"),
        8,
        "recover of x names back; expected one of o",
    ),
    "recover by itself": (body("<objective name='x' activities='go' recover='x'/>"), 8, "names x; expected"),
    "recover by an exit": (
        body(f"<objective name='x' activities='go' recover='fail'/>{OK}"),
        8,
        "recover of x names fail; expected one of o",
    ),
    "times without recover": (
        body("<objective name='x' activities='go' times='2'/>"),
        8,
        "x has times, though it has no recover",
    ),
    "recover no times": (
        body("<objective name='x' activities='go' recover='o' times='0'/>"),
        8,
        "times of x is 0, expected a whole number from 1 to",
    ),
    "recover by one that recovers": (
        body(
            "<objective name='x' activities='go' recover='y'/>\n"
            f"<objective name='y' activities='go' recover='o'/>{OK}"
        ),
        8,
        "x recovers by y, which itself recovers by o",
    ),
    "recover where a route leads back": (
        body(
            "<objective name='x' activities='go' recover='o'/>\n"
            f"<objective name='y' activities='go' failure='x'/>{OK}"
        ),
        8,
        "x recovers by o, and a route leads back to x: put it into an objective of its own",
    ),
    "recover where an event leads back": (
        body(
            f"<objective name='x' activities='go' recover='o'><on event='leak' goto='x'/></objective>{OK}",
            LEAK,
        ),
        8,
        "a route leads back to x",
    ),
    "recover of a branch": (
        body(f"<parallel name='p'>\n<objective name='x' activities='go' recover='o'/>{OK}</parallel>"),
        9,
        "recover",
    ),
    "objective with no activity named": (body("<objective name='o' activities=' '/>"), 8, "no activity"),
    "parallel in parallel": (
        body(f"<parallel name='p'>\n<parallel name='q'>\n{OK}</parallel></parallel>"),
        9,
        "parallel",
    ),
    "parameter without value": (
        body("<objective name='o' activities='go'>\n<parameter name='d'/></objective>"),
        9,
        "value",
    ),
    "activity unknown": (body("<objective name='o' activities='goo'/>"), 8, "did you mean go?"),
    "resource unknown": (robot("<activity name='a' consumes='SS'/>"), 7, "did you mean S?"),
    "product unknown": (
        robot("<activity name='a' produces='X'/>"),
        7,
        "X, which is not declared (expected one of S)",
    ),
    "product is hardware": (robot("<activity name='a' produces='H'/>"), 7, "hardware"),
    "software without producer": (
        robot("<software name='T'/>"),
        7,
        'found none: give produces="T" to the one',
    ),
    "product named twice": (
        robot("<software name='T'/><activity name='a' produces='T T'/>"),
        7,
        "produces of a names T 2 times",
    ),
    "software with two producers": (
        robot("<activity name='a' produces='S'/>"),
        3,
        'found driver, a: leave produces="S" on one',
    ),
    "resource declared twice": (robot("<hardware name='S'/>"), 3, "resource S is declared twice"),
    "activity declared twice": (robot("<activity name='go'/>"), 7, "activity go is declared twice"),
    "alternative declared twice": (
        robot("<activity name='a'><alternative name='x'/>\n<alternative name='x'/></activity>"),
        8,
        "alternative x is declared twice",
    ),
    "objective declared twice": (body(f"{OK}\n{OK}"), 9, "block o is declared twice"),
    "parameter declared twice": (
        body(
            "<objective name='o' activities='go'>\n<parameter name='d' value='1'/>\n"
            "<parameter name='d' value='2'/></objective>"
        ),
        10,
        "parameter d is declared twice",
    ),
    "activity named twice": (body("<objective name='o' activities='go go'/>"), 8, "go 2 times"),
    "resource consumed twice": (robot("<activity name='a' consumes='S S'/>"), 7, "S 2 times"),
    "objective starts a producer": (body("<objective name='o' activities='driver'/>"), 8, "by request"),
    "block called fail": (
        body(OK + "\n<each name='fail' in='a'><objective name='x' activities='go'/></each>"),
        9,
        "name of a route",
    ),
    "block called succeed": (body("<objective name='succeed' activities='go'/>"), 8, "name of a route"),
    "route to nowhere": (body("<objective name='o' activities='go' failure='p'/>"), 8, "leads to p"),
    "route into a block": (
        body(f"<objective name='r'>\n{OK}</objective>\n<objective name='x' activities='go' failure='o'/>"),
        10,
        "leads to o",
    ),
    "route on a child of a parallel block": (
        body("<parallel name='p'>\n<objective name='o' activities='go' failure='fail'/></parallel>"),
        9,
        "o has a route (failure), though it is a child of a parallel block: routes stand on p",
    ),
    "mandatory outside a parallel block": (
        body("<objective name='o' activities='go' mandatory='true'/>"),
        8,
        "mandatory is for children of a parallel block",
    ),
    "parallel with none mandatory": (
        body("<parallel name='p'><objective name='o' activities='go' mandatory='false'/></parallel>"),
        8,
        "no mandatory child",
    ),
    "parallel without children": (body("<parallel name='p'/>"), 8, "<parallel> has no blocks"),
    "retries are no number": (body(OK.replace("/>", " retries='often'/>")), 8, "expected a whole number"),
    "retries below zero": (body(OK.replace("/>", " retries='-1'/>")), 8, "expected a whole number"),
    "retries beyond the limit": (
        body(OK.replace("/>", " retries='100001'/>")),
        8,
        "retries of o is 100001, expected a whole number from 0 to 100000",
    ),
    "retries of an alternative": (
        robot("<activity name='a'>\n<alternative name='b' retries='1'/></activity>"),
        8,
        "attribute retries on <alternative>",
    ),
    "retries of a mission": (body().replace(" xmlns", " retries='1' xmlns"), 1, "attribute retries"),
    "repeat is no number": (body(OK.replace("/>", " repeat='2.5'/>")), 8, "repeat of <objective> is '2.5'"),
    "repeat below zero": (body(OK.replace("/>", " repeat='-2'/>")), 8, "expected a whole number"),
    "repeat beyond the limit": (
        body(OK.replace("/>", " repeat='100001'/>")),
        8,
        "repeat of o is 100001, expected a whole number from 1 to 100000",
    ),
    "repeat without end": (body(OK.replace("/>", " repeat='1000000'/>")), 8, "expected a whole number"),
    "repeat never": (
        body(OK.replace("/>", " repeat='0'/>")),
        8,
        "repeat of o is 0, expected a whole number from 1",
    ),
    "each without values": (body(f"<each name='e'>{OK}</each>"), 8, "<each> has no attribute in"),
    "each with an empty list": (body(f"<each name='e' in=' '>{OK}</each>"), 8, "expected values of letters"),
    "each with a value that fits no name": (
        body(f"<each name='e' in='a 1.5'>{OK}</each>"),
        8,
        "expected values",
    ),
    "each with a value twice": (body(f"<each name='e' in='a b a'>{OK}</each>"), 8, "in of e names a 2 times"),
    "each with a value of 65 characters": (
        body(f"<each name='e' in='{'v' * 65}'>{OK}</each>"),
        8,
        "expected letters, digits and _, at most 64 characters",
    ),
    "each without a name": (body(f"<each in='a'>{OK}</each>"), 8, "<each> has no attribute name"),
    "each with activities": (
        body("<each name='e' in='a' activities='go'/>"),
        8,
        "attribute activities on <each>",
    ),
    "each with the name of a block": (
        body(f"<each name='o' in='a'>\n{OK}</each>"),
        9,
        "block o is declared twice",
    ),
    "each without blocks": (body("<each name='e' in='a'/>"), 8, "<each> has no blocks"),
    "each with a parameter that is no name": (
        body(f"<each name='e' parameter='1' in='a'>{OK}</each>"),
        8,
        "parameter of <each> is '1'",
    ),
    "each with parameters": (
        body(f"<each name='e' in='a'><parameter name='p' value='1'/>{OK}</each>"),
        8,
        "found <parameter> inside <each>",
    ),
    "route out of each": (
        body(f"<each name='e' in='a'>\n<objective name='x' activities='go' success='o'/></each>{OK}"),
        9,
        "success of x leads to o; expected one of x, succeed, fail, abort",
    ),
    "route to a round": (
        body(
            "<objective name='x' activities='go' success='o_2'/>\n"
            "<objective name='o' activities='go' repeat='2'/>"
        ),
        8,
        "success of x leads to o_2; expected one of x, o",
    ),
    "round with the name of a block": (
        body("<objective name='o' activities='go' repeat='2'/>\n<objective name='o_2' activities='go'/>"),
        8,
        "o_2, a round, a try or a run of o, would have the name of another block: o_2",
    ),
    "try with the name of another's round": (
        body(
            "<each name='e' in='b_1 1'>\n<objective name='a' activities='go'/>\n"
            "<objective name='a_b' activities='go'/></each>"
        ),
        9,
        "a_b_1, a round, a try or a run of a, would have the name of another block: a_b",
    ),
    "event twice": (robot("<event name='e'/>\n<event name='e'/>"), 8, "event e is declared twice"),
    "event of two robots": (
        body("<robot name='q'>\n<event name='leak'/></robot>" + OK, LEAK),
        9,
        "event leak is declared twice",
    ),
    "event without a name": (robot("<event/>"), 7, "<event> has no attribute name"),
    "event with a bad name": (robot("<event name='a leak'/>"), 7, "name of <event> is 'a leak'"),
    "event that leads somewhere": (
        robot("<event name='e' goto='fail'/>"),
        7,
        "attribute goto on <event>",
    ),
    "event in a mission": (body("<event name='e'/>" + OK), 8, "found <event> inside <mission>"),
    "event that is hardware": (
        body(OK.replace("/>", ">\n<on event='H' goto='fail'/></objective>"), LEAK),
        9,
        "o handles the event H, which is not declared",
    ),
    "event that nobody declares": (
        body(OK.replace("/>", ">\n<on event='leek' goto='fail'/></objective>"), LEAK),
        9,
        "o handles the event leek, which is not declared (did you mean leak?)",
    ),
    "event handled twice": (
        body(
            f"<objective name='o' activities='go'>\n{ON_LEAK}{ON_LEAK}</objective>",
            LEAK,
        ),
        9,
        "o handles the event leak twice",
    ),
    "event handled twice by the mission": (
        body(f"{ON_LEAK}\n{ON_LEAK}{OK}", LEAK),
        9,
        "m handles the event leak twice",
    ),
    "event of a use that leads into its protocol": (
        body(
            PROTOCOLS.format(OK, OK)
            + "<use name='u' protocol='p'>\n<on event='leak' goto='o'/></use>"
            + "<objective name='x' activities='go'/>",
            LEAK,
        ),
        12,
        "the event leak of u leads to o; expected one of u, x, succeed, fail, abort",
    ),
    "event of each that leads to a block in it": (
        body(f"<each name='e' in='a'>\n<on event='leak' goto='o'/>{OK}</each>", LEAK),
        9,
        "the event leak of e leads to o; expected one of e, succeed, fail, abort",
    ),
    "event that leads to a round": (
        body(
            "<objective name='x' activities='go' repeat='2'>\n<on event='leak' goto='x_2'/></objective>",
            LEAK,
        ),
        9,
        "the event leak of x leads to x_2; expected one of x, succeed, fail, abort",
    ),
    "event that leads to a near name": (
        body(OK.replace("/>", ">\n<on event='leak' goto='fial'/></objective>"), LEAK),
        9,
        "leads to fial; expected one of o, succeed, fail, abort (did you mean fail?)",
    ),
    "event that leads nowhere": (
        body("<objective name='o' activities='go'>\n<on event='leak' goto='surfacing'/></objective>", LEAK),
        9,
        "the event leak of o leads to surfacing; expected one of o, succeed, fail, abort",
    ),
    "event that leads into a block": (
        body(f"\n<on event='leak' goto='o'/><objective name='r'>{OK}</objective>", LEAK),
        9,
        "the event leak of m leads to o; expected one of r, succeed, fail, abort",
    ),
    "event of a parallel branch that leads to its sibling": (
        body(
            "<parallel name='p'><objective name='o' activities='go'>\n<on event='leak' goto='q'/></objective>"
            "<objective name='q' activities='look'/></parallel>",
            LEAK,
        ),
        9,
        "the event leak of o leads to q; expected one of succeed, fail, abort",
    ),
    "hardware of no such status": (robot("<hardware name='G' initial='broken'/>"), 7, "initial"),
    "hardware that cannot fail is out of service": (
        robot("<hardware name='G' faulty='false' initial='oos'/>"),
        7,
        "G is out of service at the start, though it cannot fail",
    ),
    "hardware that cannot fail is not repairable": (
        robot("<hardware name='G' faulty='false' repairable='false'/>"),
        7,
        "G is not repairable, though it cannot fail",
    ),
    "hardware that cannot fail is asked": (
        robot("<hardware name='G' faulty='false' demand_probability='0.5'/>"),
        7,
        "G has a demand_probability, though it cannot fail",
    ),
    "hardware that fails too often on demand": (
        robot("<hardware name='G' demand_probability='1.5'/>"),
        7,
        "demand_probability of G is 1.5, expected a number from 0 to 1",
    ),
    "hardware that is never in service": (
        robot("<hardware name='G' repairable='false' initial='oos'/>"),
        7,
        "G is out of service at the start and not repairable: it is never in service",
    ),
    "hardware that is not repairable is repaired": (
        robot("<hardware name='G' repairable='false' repair_rate='1'/>"),
        7,
        "G has a repair_rate, though it is not repairable",
    ),
    "fault that lasts is repaired": (
        robot("<fault name='f' affects='H' repairable='false' repair_rate='1'/>"),
        7,
        "f has a repair_rate, though it is not repairable",
    ),
    "activity that crashes more often than ever": (
        robot("<activity name='b' consumes='H' faulty='true' failure_rate='-1'/>"),
        7,
        "failure_rate",
    ),
    "activity that is faulty or not": (
        robot("<activity name='b' consumes='H' faulty='perhaps'/>"),
        7,
        "faulty of <activity> is 'perhaps'",
    ),
    "activity that crashes though it is not faulty": (
        robot("<activity name='b' consumes='H' failure_rate='1'/>"),
        7,
        'activity b has a failure_rate, though it never crashes: add faulty="true"',
    ),
    "activity that never recovers though it is not faulty": (
        robot("<activity name='b' consumes='H' recovers='false'/>"),
        7,
        'activity b does not recover, though it never crashes: add faulty="true"',
    ),
    "alternative that never recovers and does": (
        robot(
            "<activity name='b'>"
            "<alternative name='w' faulty='true' recovers='false' repair_rate='1'/></activity>"
        ),
        7,
        "alternative w of b has a repair_rate, though it never recovers",
    ),
    "activity that crashes under the name of a resource": (
        robot("<hardware name='b'/><activity name='b' consumes='H' faulty='true'/>"),
        7,
        "activity b is faulty, though a resource is called b too",
    ),
    "hardware detected at some time": (robot("<hardware name='G' detected='soon'/>"), 7, "detected"),
    "hardware that cannot fail is detected late": (
        robot("<hardware name='G' faulty='false' detected='late'/>"),
        7,
        "G is detected late, though it cannot fail",
    ),
    "shared hardware is detected late": (
        robot("<hardware name='G' shared='true' detected='late'/>"),
        7,
        "G is detected late and shared",
    ),
    "detection_rate of what detects nothing": (
        robot("<activity name='b' consumes='H' detection_rate='1'/>"),
        7,
        "activity b has a detection_rate, but detects nothing",
    ),
    "detection_rate below 0": (
        robot(
            "<hardware name='G' detected='late'/>"
            "<activity name='b' consumes='H' detects='G' detection_rate='-1'/>"
        ),
        7,
        "detection_rate",
    ),
    "activity that detects what is known": (
        robot("<activity name='b' consumes='H' detects='H'/>"),
        7,
        "activity b detects H, whose loss is known at once: say that it is detected late",
    ),
    "activity that detects what is not declared": (
        robot("<activity name='b' consumes='H' detects='HH'/>"),
        7,
        "activity b detects HH, which is not declared",
    ),
    "activity that detects software": (
        robot(
            "<hardware name='G'/><software name='s'/><activity name='p' produces='s' consumes='G'/>"
            "<activity name='b' consumes='H' detects='s'/>"
        ),
        7,
        "activity b detects s, which is no hardware",
    ),
    "hardware that two activities detect": (
        robot(
            "<hardware name='G' detected='late'/><activity name='b' consumes='G' detects='G'/>"
            "<activity name='c' consumes='H' detects='G'/>"
        ),
        7,
        "activities b and c both detect G, expected one of them",
    ),
    "fault of nothing": (robot("<fault name='f' affects=''/>"), 7, "fault f affects nothing"),
    "fault without what it affects": (robot("<fault name='f'/>"), 7, "<fault> has no attribute affects"),
    "fault of what is not declared": (
        robot("<fault name='f' affects='HH'/>"),
        7,
        "fault f affects HH, which is not declared (did you mean H?)",
    ),
    "fault of software": (
        robot("<software name='s'/><activity name='p' produces='s'/>\n<fault name='f' affects='H s'/>"),
        8,
        "fault f affects s, which is software",
    ),
    "fault that affects one twice": (
        robot("<fault name='f' affects='H H'/>"),
        7,
        "affects of f names H 2 times",
    ),
    "fault with the name of hardware": (
        robot("<fault name='H' affects='H'/>"),
        7,
        "resource H is declared twice",
    ),
    "fault with a negative rate": (
        robot("<fault name='f' affects='H' failure_rate='-1'/>"),
        7,
        "failure_rate of <fault> is '-1'",
    ),
    "fault that is consumed": (
        robot("<fault name='f' affects='H'/>\n<activity name='c' consumes='f'/>"),
        8,
        "alternative c of activity c consumes f, which is not declared",
    ),
    "abort that leads nowhere": (
        body(f"\n<objective name='r' abort='surface'>{OK}</objective>"),
        9,
        "abort of r leads to surface; expected one of r, succeed, fail, abort",
    ),
    "abort that leads to a near name": (
        body(f"<objective name='r' abort='homme'>{OK}</objective><objective name='home' activities='go'/>"),
        8,
        "did you mean home?",
    ),
    "abort that leads into a block": (
        body(f"<objective name='r'>{OK}</objective>\n<objective name='s' abort='o' activities='go'/>"),
        9,
        "abort of s leads to o; expected one of r, s, succeed, fail, abort",
    ),
    "abort that leads out of an each": (
        body(f"<each name='e' in='1'>\n<objective name='x' activities='go' abort='o'/></each>{OK}"),
        9,
        "abort of x leads to o; expected one of x, succeed, fail, abort",
    ),
    "abort of a branch that leads to its sibling": (
        body(
            "<parallel name='p'><objective name='o' activities='go'/>\n"
            "<objective name='q' abort='o' activities='look'/></parallel>"
        ),
        9,
        "abort of q leads to o; expected one of succeed, fail, abort",
    ),
    "abort of a use that leads into its protocol": (
        body(PROTOCOLS.format(OK, OK) + "<use name='u' protocol='p' abort='o'/>"),
        11,
        "abort of u leads to o; expected one of u, succeed, fail, abort",
    ),
    "abort of no name": (
        body(f"<objective name='r' abort='a b'>{OK}</objective>"),
        8,
        "abort of <objective> is 'a b'",
    ),
    "abort of a mission": (
        body().replace("<mission ", "<mission abort='o' "),
        1,
        "found the attribute abort on <mission>",
    ),
    "abort of a handler": (
        body("<on event='leak' goto='fail' abort='fail'/>" + OK, LEAK),
        8,
        "found the attribute abort on <on>",
    ),
    "block called abort": (
        body("<objective name='abort' activities='go'/>"),
        8,
        "a block cannot be called abort, the name of a route",
    ),
    "on without goto": (
        body("<on event='leak'/>" + OK, LEAK),
        8,
        "the event leak of m leads nowhere; expected one of goto and pause",
    ),
    "on without event": (
        body("<on goto='fail'/>" + OK, LEAK),
        8,
        "an <on> of m has neither event nor when; expected one of them",
    ),
    "on with a bad goto": (
        body("<on event='leak' goto='a b'/>" + OK, LEAK),
        8,
        "goto of <on> is 'a b'",
    ),
    "on with a block": (
        body(f"<on event='leak' goto='fail'>{OK}</on>" + OK, LEAK),
        8,
        "found <objective> inside <on>",
    ),
    "on in a robot": (
        body(OK, LEAK.replace("</robot>", f"{ON_LEAK}</robot>")),
        7,
        "found <on> inside <robot>",
    ),
    "on with a name": (
        body("<on name='a' event='leak' goto='fail'/>" + OK, LEAK),
        8,
        "attribute name on <on>",
    ),
    "on after a block": (body(OK + ON_LEAK, LEAK), 8, "found <on> after a block of <mission>"),
    "on in a protocol": (
        body(PROTOCOLS.format(ON_LEAK + OK, OK) + OK, LEAK),
        9,
        "found <on> inside <protocol>",
    ),
    "once that is no truth": (
        body("<on event='leak' goto='fail' once='maybe'/>" + OK, LEAK),
        8,
        "once of <on> is 'maybe', expected true or false",
    ),
    "activities need each other": (
        robot(
            "<software name='A'/><software name='B'/>"
            "<activity name='a' produces='A' consumes='B'/><activity name='b' produces='B' consumes='A'/>"
        ),
        7,
        "a -> b -> a",
    ),
    "activity needs its own product": (
        robot("<software name='A'/><activity name='a' produces='A' consumes='A'/>"),
        7,
        "a -> a",
    ),
    "protocol unknown": (
        body("<use name='u' protocol='p'/>"),
        8,
        "p, which is not declared (none is declared)",
    ),
    "protocol declared twice": (
        body(PROTOCOLS.replace("'q'", "'p'").replace('"q"', '"p"').format(OK, OK) + OK),
        10,
        "protocol p is declared twice",
    ),
    "protocol uses itself": (
        body(PROTOCOLS.format('<use name="u" protocol="p"/>', OK) + OK),
        9,
        "p -> p",
    ),
    "protocols use each other": (
        body(PROTOCOLS.format('<use name="u" protocol="q"/>', '<use name="u" protocol="p"/>') + OK),
        9,
        "p -> q -> p",
    ),
    "override of no parameter": (
        body(
            PROTOCOLS.format(OK, OK)
            + '<use name="u" protocol="p">\n<parameter name="depth" value="1"/></use>'
        ),
        12,
        "does not have",
    ),
    "import of nothing": (body('<import href="no.xml"/>\n' + OK), 8, "no such file"),
    "import upwards": (body('<import href="../secret.xml"/>\n' + OK), 8, "leaves the mission's directory"),
    "import of an absolute path": (
        body('<import href="/etc/hostname"/>\n' + OK),
        8,
        "leaves the mission's directory",
    ),
    "import over the network": (
        body('<import href="http://127.0.0.1/r.xml"/>\n' + OK),
        8,
        "leaves the mission's directory",
    ),
    "import of itself": (body('<import href="m.xml"/>\n' + OK), 8, "cycle of imports"),
    "name of 256 characters": (body(f"<objective name='{'n' * 256}' activities='go'/>"), 8, "at most 255"),
    "name with a line break": (body("<objective name='o&#10;' activities='go'/>"), 8, "letters, digits"),
    "names with a space that XML does not know": (
        robot("<activity name='a' consumes='H\u00a0S'/>"),
        7,
        "consumes of <activity>",
    ),
    "attribute of another namespace": (
        body("<objective xmlns:x='urn:x' x:name='o' name='o' activities='go'/>"),
        8,
        "{urn:x}name",
    ),
    "element of another namespace": (body("<objective xmlns='urn:x' name='o'/>"), 8, "found <objective>"),
    "text between blocks": (body(f"{OK}\nand then"), 8, "found the text 'and then'"),
    "text in a block": (body("<objective name='o' activities='go'>now</objective>"), 8, "the text 'now'"),
    "import after a block": (body(f"{OK}\n<import href='r.xml'/>"), 9, "expected before its first block"),
    "parameter after a block of a protocol": (
        body(PROTOCOLS.format(OK, f"{OK}\n<parameter name='d' value='1'/>") + OK),
        11,
        "expected before its first block",
    ),
    "protocol without blocks": (body(PROTOCOLS.format(OK, "") + OK), 10, "<protocol> has no blocks"),
    "activity with two forms": (
        robot("<activity name='a' consumes='H'><alternative name='b'/></activity>"),
        7,
        "both consumes and <alternative>",
    ),
    "robot declared twice": (
        body(f"<robot name='s'/>\n<robot name='s'/>{OK}"),
        9,
        "robot s is declared twice",
    ),
    "block declared twice at two depths": (
        body(f"<objective name='r'>{OK}</objective>\n{OK}"),
        9,
        "block o is declared twice",
    ),
    "route with a near name for an exit": (
        body("<objective name='first' activities='go' success='succed'/>"),
        8,
        "expected one of first, succeed, fail, abort (did you mean succeed?)",
    ),
    "route with a near name": (
        body(f"<objective name='first' activities='go' failure='frist'/>\n{OK}"),
        8,
        "did you mean first?",
    ),
    "override of what only an inner protocol has": (
        body(
            PROTOCOLS.format('<use name="v" protocol="q"/>', '<parameter name="depth" value="1"/>' + OK)
            + '<use name="u" protocol="p">\n<parameter name="depth" value="1"/></use>'
        ),
        12,
        "does not have",
    ),
    "entity in an attribute": (
        '<!DOCTYPE m [<!ENTITY a "' + "a" * 100_000 + '">]>' + body(f'<use name="{"&a;" * 100_000}"/>'),
        8,
        "not well-formed",
    ),
    "import of a directory": (body('<import href="."/>\n' + OK), 8, "a directory"),
    "nested too deep": (
        body("<objective name='r'>" * 100 + OK + "</objective>" * 100),
        8,
        "deep",
    ),
    "nested 100,000 deep": (body("<objective name='r'>" * 100_000), 8, "not well-formed"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_mission_is_told_with_its_line(name: str, tmp_path: Path) -> None:
    text, line, message = BROKEN[name]
    path = tmp_path / "m.xml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_mission(path)
    told = [
        (p.source.line, p.message) for p in caught.value.problems if p.source and p.source.file == str(path)
    ]
    assert [m for where, m in told if where == line and message in m], caught.value


@pytest.mark.parametrize(
    "name",
    [
        "route on a child of a parallel block",
        "mandatory outside a parallel block",
        "element misspelt",
        "attribute misspelt",
        "names with a comma",
    ],
)
def test_one_mistake_is_told_once(name: str, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(BROKEN[name][0])
    with pytest.raises(InputError) as caught:
        read_mission(path)
    assert len(caught.value.problems) == 1


def test_there_are_at_least_40() -> None:
    assert len(BROKEN) >= 40


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("UTF-16 without a mark", body().encode("utf-16-le")),
        ("bytes that are no UTF-8", body().replace('name="m"', 'name="\u00e9"').encode("latin-1")),
        ("unknown encoding", b'<?xml version="1.0" encoding="EBCDIC-9"?>' + body().encode()),
        ("a wrong claim", b'<?xml version="1.0" encoding="UTF-16"?>' + body().encode()),
        ("zero bytes", b"\0" * 100),
        ("an executable", b"\x7fELF" + bytes(range(256))),
    ],
)
def test_wrong_encodings_are_told(name: str, data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"m\.xml:1: "):
        read_mission(path)


def test_missing_files_and_directories_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_mission(tmp_path / "m.xml")
    with pytest.raises(InputError, match="found a directory"):
        read_mission(tmp_path)


def test_huge_files_are_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    with path.open("wb") as file:
        file.truncate(MAX_FILE_BYTES + 1)
    with pytest.raises(InputError, match="larger than"):
        read_mission(path)


def test_import_cycles_through_other_files_are_told(tmp_path: Path) -> None:
    for name, other in (("a", "b"), ("b", "a")):
        (tmp_path / f"{name}.xml").write_text(
            f'<robot name="{name}" {NS}>\n<import href="{other}.xml"/></robot>'
        )
    (tmp_path / "m.xml").write_text(body('<import href="a.xml"/>' + OK))
    with pytest.raises(InputError, match=r"b\.xml:2: .*cycle of imports"):
        read_mission(tmp_path / "m.xml")


@pytest.mark.skipif(sys.platform == "win32", reason="needs symbolic links")
def test_links_do_not_lead_out_of_the_directory(tmp_path: Path) -> None:
    (tmp_path / "outside.xml").write_text(ROBOT.replace("<robot ", f"<robot {NS} "))
    inside = tmp_path / "in"
    inside.mkdir()
    (inside / "r.xml").symlink_to(tmp_path / "outside.xml")
    (inside / "m.xml").write_text(body('<import href="r.xml"/>' + OK, robot=""))
    with pytest.raises(InputError, match="leaves the mission's directory"):
        read_mission(inside / "m.xml")


def test_an_imported_mission_is_refused(tmp_path: Path) -> None:
    (tmp_path / "other.xml").write_text(body())
    (tmp_path / "m.xml").write_text(body('<import href="other.xml"/>' + OK))
    with pytest.raises(InputError, match="expected <robot> or <protocols>"):
        read_mission(tmp_path / "m.xml")


def test_all_problems_of_all_files_are_told_in_one_go(tmp_path: Path) -> None:
    (tmp_path / "r.xml").write_text(f'<robot name="q" {NS}>\n<hardware/>\n<engine name="e"/></robot>')
    (tmp_path / "s.xml").write_text(f'<robot name="q" {NS}>\n<activity/></robot>')
    text = '<import href="r.xml"/><import href="s.xml"/><import href="t.xml"/>' + OK
    (tmp_path / "m.xml").write_text(body(text))
    with pytest.raises(InputError) as caught:
        read_mission(tmp_path / "m.xml")
    files = [Path(p.source.file).name for p in caught.value.problems if p.source]
    assert set(files) == {"m.xml", "r.xml", "s.xml"}
    assert files == sorted(files)


def test_references_are_told_beside_misplaced_routes(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(
        body("<objective name='o' activities='goo' mandatory='true'/>\n<use name='u' protocol='p'/>")
    )
    with pytest.raises(InputError) as caught:
        read_mission(tmp_path / "m.xml")
    assert [p.source.line for p in caught.value.problems if p.source] == [8, 8, 9]


def test_a_near_name_is_one_that_may_stand_there(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(
        body("<objective name='x' activities='goo' failure='goo'/>\n<objective name='good' activities='go'/>")
    )
    with pytest.raises(InputError) as caught:
        read_mission(tmp_path / "m.xml")
    told = sorted(p.message for p in caught.value.problems)
    assert told == [
        "failure of x leads to goo; expected one of x, good, succeed, fail, abort (did you mean good?)",
        "objective x runs goo, which is not declared (did you mean go?)",
    ]


def test_a_product_named_twice_is_one_problem(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(robot("<software name='T'/><activity name='a' produces='T T'/>"))
    with pytest.raises(InputError) as caught:
        read_mission(tmp_path / "m.xml")
    assert [p.message for p in caught.value.problems] == ["produces of a names T 2 times"]


def test_references_are_not_judged_by_half_of_the_files(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(body(f'<import href="no.xml"/>{OK}', robot=""))
    with pytest.raises(InputError) as caught:
        read_mission(tmp_path / "m.xml")
    assert [p.message for p in caught.value.problems] == ["import of no.xml: no such file"]


def test_elements_are_bounded(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(body("<i/>" * MAX_ELEMENTS))
    with pytest.raises(InputError, match="more than 200000 elements"):
        read_mission(tmp_path / "m.xml")


def test_chains_of_imports_are_bounded(tmp_path: Path) -> None:
    for i in range(500):
        text = f'<robot name="r{i}" {NS}><import href="r{i + 1}.xml"/></robot>'
        (tmp_path / f"r{i}.xml").write_text(text)
    (tmp_path / "m.xml").write_text(body(f'<import href="r0.xml"/>{OK}'))
    with pytest.raises(InputError, match=r"r63\.xml:1: .*more than 64 files deep"):
        read_mission(tmp_path / "m.xml")


def protocols(number: int, level: str, bottom: str = OK) -> str:
    """Protocols of which each holds the level, with the following one for NEXT, and a use of the first."""
    inner = "".join(
        f'<protocol name="p{i}">{level.replace("NEXT", f"p{i + 1}")}</protocol>' for i in range(number)
    )
    last = f'<protocol name="p{number}">{bottom}</protocol>'
    return f'<protocols>{inner}{last}</protocols><use name="u" protocol="p0"/>'


USE = '<use name="a" protocol="NEXT"/>'
EXPANSIONS = {
    "doubled 40 times": (protocols(40, USE + USE.replace('"a"', '"b"')), "100000 objectives"),
    "a chain": (protocols(3000, USE), "128 deep"),
    "a chain at the second place": (protocols(3000, OK + USE), "128 deep"),
    "a chain through parallel blocks": (
        protocols(3000, f'<parallel name="p"><objective name="r">{USE}</objective></parallel>'),
        "128 deep",
    ),
    "rounds of rounds": (
        "<each name='e' in='1 2 3'><objective name='a' repeat='1000'><objective name='b' repeat='1000'>"
        + OK.replace("/>", " retries='1000'/>")
        + "</objective></objective></each>",
        "100000 objectives",
    ),
    "tries of rounds": (OK.replace("/>", " retries='99999' repeat='99999'/>"), "100000 objectives"),
    "parameters times objectives": (
        protocols(
            14,
            USE + USE.replace('"a"', '"b"'),
            "".join(f'<parameter name="d{i}" value="1"/>' for i in range(100)) + OK,
        ),
        "1000000 parameters",
    ),
}


@pytest.mark.parametrize("name", EXPANSIONS)
def test_expansions_hit_a_limit(name: str, tmp_path: Path) -> None:
    blocks, limit = EXPANSIONS[name]
    (tmp_path / "m.xml").write_text(body(blocks))
    found = read_mission(tmp_path / "m.xml")
    with pytest.raises(LimitError, match=rf"m\.xml:\d+: .*{limit}"):
        flatten(found)


def test_nesting_up_to_the_limit_is_flattened(tmp_path: Path) -> None:
    level = f'<parallel name="p"><objective name="r">{USE}</objective></parallel>'
    (tmp_path / "m.xml").write_text(body(protocols(MAX_NESTING // 3, level)))
    graph = flatten(read_mission(tmp_path / "m.xml"))
    assert [s.name for s in graph.walk()] == ["u." + "a." * (MAX_NESTING // 3) + "o"]
    assert graph.to_networkx().number_of_nodes() > MAX_NESTING // 3


# Seconds of one core: linear checks need less than two, quadratic ones more than fifteen.
LARGE = {
    "activities in a chain": (
        robot(
            "".join(
                f'<software name="s{i}"/><activity name="a{i}" produces="s{i}" consumes="s{i + 1}"/>'
                for i in range(30_000)
            )
            + '<software name="s30000"/><activity name="b" produces="s30000" consumes="s0"/>'
        ),
        "activities need each other's resources: a0 -> a1",
    ),
    "routes to nowhere": (
        body("".join(f'<objective name="o{i}" activities="go" failure="x{i}"/>' for i in range(30_000))),
        "its 30000 siblings",
    ),
    "unknown activities": (
        body("".join(f'<objective name="o{i}" activities="x{i}"/>' for i in range(30_000))),
        "runs x29999",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LARGE)
def test_large_files_are_told_soon(name: str, tmp_path: Path) -> None:
    text, message = LARGE[name]
    (tmp_path / "m.xml").write_text(text)
    started = time.process_time()
    with pytest.raises(InputError) as caught:
        read_mission(tmp_path / "m.xml")
    assert message in str(caught.value)
    assert time.process_time() - started < 8


def elementary(name: str = "o", **more: Any) -> Objective:
    return Objective(name=name, activities=("a",), **more)


def built(*blocks: Block, **more: Any) -> Mission:
    activities = (Activity(name="a", alternatives=(Alternative(name="a"),)),)
    return Mission(name="m", blocks=blocks, robots=(Robot(name="r", activities=activities),), **more)


# What files cannot say, the schema sees to that, but Python can.
BUILT: dict[str, tuple[Mission, str]] = {
    "no blocks": (built(), "m has no blocks"),
    "recursive without blocks": (built(Recursive(name="r", blocks=())), "r has no blocks"),
    "parallel without blocks": (built(Parallel(name="p", blocks=())), "p has no blocks"),
    "protocol without blocks": (
        built(elementary(), protocols=(Protocol(name="p", blocks=()),)),
        "p has no blocks",
    ),
    "each without blocks": (built(Each(name="e", values=("a",), blocks=())), "e has no blocks"),
    "each without values": (built(Each(name="e", values=(), blocks=(elementary(),))), "e names no value"),
    "value that fits no name": (
        built(Each(name="e", values=("1.5",), blocks=(elementary(),))),
        "the value '1.5', expected letters",
    ),
    "parameter that is no name": (
        built(Each(name="e", parameter="a b", values=("a",), blocks=(elementary(),))),
        "the parameter of e, 'a b', is no name",
    ),
    "repeat below one": (built(elementary(repeat=-1)), "repeat of o is -1"),
    "too many retries": (built(elementary(retries=10**9)), "retries of o is 1000000000"),
    "bad name": (built(elementary("a.b")), "the name 'a.b' is not allowed"),
    "route inside a parallel block": (
        built(Parallel(name="p", blocks=(elementary(success="fail"),))),
        "o has a route",
    ),
    "optional outside a parallel block": (built(elementary(mandatory=False)), "o is not mandatory"),
    "activity without alternatives": (
        Mission(
            name="m",
            blocks=(elementary(),),
            robots=(Robot(name="r", activities=(Activity(name="a", alternatives=()),)),),
        ),
        "activity a has no alternative",
    ),
}


@pytest.mark.parametrize("name", BUILT)
def test_missions_built_in_python_are_checked_too(name: str) -> None:
    mission, message = BUILT[name]
    assert [p for p in find_errors(mission) if message in p.message], find_errors(mission)
    assert find_errors(built(elementary())) == []


def test_what_xml_cannot_hold_is_told() -> None:
    for text in ("\0", "\ud800", "\ufffe"):
        with pytest.raises(InputError, match="mission m cannot be written"):
            write_mission(built(elementary(), description=text))


NAMES = st.sampled_from(["a", "b", "go", "H", "S", "p", "succeed", "fail", "m", "x y", "1", "2", "true", ""])
TAGS = ["mission", "robot", "protocols", "protocol", "objective", "parallel", "use", "parameter", "import"]
TAGS += ["hardware", "software", "activity", "alternative", "each", "event", "on", "unknown"]
ATTRIBUTES = ["name", "activities", "success", "failure", "mandatory", "protocol", "consumes", "produces"]
ATTRIBUTES += ["value", "unit", "href", "faulty", "shared", "exclusive", "switch_back", "retries", "repeat"]
ATTRIBUTES += ["in", "parameter", "event", "goto", "once", "description", "unknown"]


@st.composite
def trees(draw: st.DrawFn, depth: int = 3) -> str:
    """Any tree of the language's words."""
    tag = draw(st.sampled_from(TAGS))
    attributes = draw(st.dictionaries(st.sampled_from(ATTRIBUTES), NAMES, max_size=4))
    children = draw(st.lists(trees(depth - 1), max_size=3)) if depth else []
    said = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f"<{tag}{said}>{''.join(children)}</{tag}>"


def reads_or_tells(path: Path) -> None:
    """A file gives a valid mission that survives writing, or located problems in order."""
    problems: tuple[Problem, ...] = ()
    try:
        mission: Mission | None = read_mission(path)
    except InputError as error:
        problems = error.problems
        mission = None
    if mission is None:
        places = [(p.source.file, p.source.line or 0) for p in problems if p.source]
        assert places == sorted(places)
        assert len(places) == len(problems) > 0
        return
    assert find_errors(mission) == []
    try:
        flatten(mission)
    except LimitError:  # of rounds, tries or their products
        event("too many rounds")
    find_warnings(mission)
    path.write_bytes(write_mission(mission))
    assert read_mission(path) == mission


@fewer(0.5)
@given(st.lists(trees(), max_size=3), st.booleans())
def test_any_tree_is_read_or_told(
    tmp_path_factory: pytest.TempPathFactory, parts: list[str], sound: bool
) -> None:
    path = tmp_path_factory.mktemp("tree") / "m.xml"
    path.write_text(body("".join(parts) + OK * sound))
    reads_or_tells(path)


@given(st.data())
def test_any_damage_is_read_or_told(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.mktemp("damage")
    mission = data.draw(st.sampled_from(["ulysse", "drone", "glider", "rover", "courier"]))
    for source in (ULYSSE.parents[1] / mission).glob("*.xml"):
        (folder / source.name).write_bytes(source.read_bytes())
    path = folder / data.draw(st.sampled_from(["mission.xml", "robot.xml", "protocols.xml"]))
    content = path.read_bytes()
    start = data.draw(st.integers(0, len(content) - 1))
    length = data.draw(st.integers(0, 60))
    insert = data.draw(st.binary(max_size=4) | st.sampled_from([b"<", b'"', b"&x;", b"a", b"</robot>"]))
    path.write_bytes(content[:start] + insert + content[start + length :])
    reads_or_tells(folder / "mission.xml")
