"""The domain: what a fit is, which moves it may make, and what the service does with it. No framework is known here."""
