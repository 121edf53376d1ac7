"""A profile for a robot of which there is a URDF: what it says, what is asked, what is written."""

from pa10d.services.new_profile.answers import Answers, answers_for
from pa10d.services.new_profile.facts import ArmFacts, facts_of
from pa10d.services.new_profile.text import profile_text
from pa10d.services.new_profile.write import write_profile

__all__ = ["Answers", "ArmFacts", "answers_for", "facts_of", "profile_text", "write_profile"]
