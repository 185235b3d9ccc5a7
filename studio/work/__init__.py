"""Answers to what a person does, computed in processes of their own: each a function of its arguments alone.

What is dear, such as a dissected plan, is kept by the digest of what it was made from; nothing depends on it.
"""
