"""Zero sets out: meshes and curves as files."""
