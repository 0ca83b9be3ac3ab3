"""Stable markings, and the proof that each event leads to one: internal evolution is confluent and ends.

Which module is which step of the argument (``papers/mcpn.md``, section 3):

1. Where two enabled internal transitions commute, the order of the two does not matter:
   :mod:`~mcpn.spaces.stable.confluence_by_ranks` finds the conflicts that leave this open (Propositions 1
   and 2).
2. Where conflicts are left open, :mod:`~mcpn.spaces.stable.representatives` explores what is behind each
   event, one marking for all that evolve alike.
3. :mod:`~mcpn.spaces.stable.confluence_by_sets` is the symbolic proof: 1, then 2, on the diagram of all
   reachable markings.
4. :mod:`~mcpn.spaces.stable.run_to_completion` runs events to completion without that diagram, in
   enough orders of internal transitions to prove each outcome (stubborn sets, Proposition 3).
   :mod:`~mcpn.spaces.stable.alternatives` builds the alternatives graph so, or by reduction of the markings
   graph; :mod:`~mcpn.spaces.stable.big_steps` does it for many stable states at once (Propositions 4, 5).
   :mod:`~mcpn.spaces.stable.alternatives` lists the states of any engine as such a graph.

Where the proof fails, :mod:`~mcpn.spaces.stable.nearest_nonconfluence` looks for the nearest counterexample,
:mod:`~mcpn.spaces.stable.run_to_completion` finds the two firings that decide the outcome, and
:mod:`~mcpn.composite.clash` finds which elements of the mission want the same
(:mod:`~mcpn.composite.clash` says it).
"""
