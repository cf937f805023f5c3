"""Design of controllers: margins and bounds before anything turns."""
