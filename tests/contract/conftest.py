"""What pytest does not look into."""

collect_ignore = ["clients"]  # programs that import generated clients; test_clients.py runs them
