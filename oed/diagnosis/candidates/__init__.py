"""How one candidate is refined, ranked among others, and judged."""
