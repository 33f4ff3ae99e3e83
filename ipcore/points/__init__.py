"""The data of a fit: points that are validated, streamed, sampled, given normals and oriented."""
