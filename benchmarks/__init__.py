"""Development only: speed beside public libraries. Nothing on board imports this."""
