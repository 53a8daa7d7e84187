"""Long work in a process of its own: jobs, progress, stopping, and what is said when it dies."""
