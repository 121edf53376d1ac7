"""Requests that move the arm, carried out as jobs."""
