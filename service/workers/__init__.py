"""Worker processes, the pool that runs and kills them, and the tasks that they run."""
