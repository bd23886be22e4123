"""What a run leaves on disk: folder, checkpoint, pictures, report."""
