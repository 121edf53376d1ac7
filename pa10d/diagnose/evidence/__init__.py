"""Is a candidate real, and how sure are its values? Statistics on runs a fit has not seen."""
