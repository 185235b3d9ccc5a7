"""Every parameter with its unit, meaning and source."""
