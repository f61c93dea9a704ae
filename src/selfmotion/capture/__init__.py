"""From raw measurement to recordings that the methods take."""
