"""The queues of accepted fits, and what runs them: embedded in one server, or in PostgreSQL for a cluster."""
