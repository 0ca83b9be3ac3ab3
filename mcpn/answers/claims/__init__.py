"""Claims: what mcpn says of a mission, each with the formula that shows it, its assumptions and its words.

A kind of claim is a row of :data:`mcpn.answers.kinds.by_name.KINDS`; :mod:`mcpn.answers.claims.made` makes
the claims of one mission. Whoever shows them chooses, orders and folds; the words are those of the kind.
"""

from __future__ import annotations

from mcpn.answers.claims.claim import Assumes as Assumes
from mcpn.answers.claims.claim import Claim as Claim
from mcpn.answers.claims.made import claims_of as claims_of
from mcpn.answers.claims.made import claims_of_losses as claims_of_losses
from mcpn.answers.claims.sets import all_claims as all_claims
from mcpn.answers.claims.sets import claims_of_causes as claims_of_causes
from mcpn.answers.kinds.by_name import KINDS as KINDS
from mcpn.answers.kinds.kind import ClaimKind as ClaimKind
