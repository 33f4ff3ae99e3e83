"""Storage: fits in a SQL database, point sets as blobs on a file system or an object store."""
