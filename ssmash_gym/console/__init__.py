"""A person at the claw: the page, its server, and recordings shown in the same scene."""
