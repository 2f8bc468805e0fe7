"""Fields larger than one machine: tasks, their memory, and what they leave in a store."""
