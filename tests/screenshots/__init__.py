"""Pictures of the documents, made by driving the window."""
