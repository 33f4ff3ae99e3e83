ARG PYTHON_IMAGE=python:3.13-slim

FROM ${PYTHON_IMAGE} AS builder
# A private index, if there is one: --build-arg PIP_INDEX_URL=… (the hashes in the lock still decide what is accepted).
ARG PIP_INDEX_URL
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1
WORKDIR /src
RUN python -m venv /opt/venv
COPY requirements.lock ./
RUN /opt/venv/bin/pip install --quiet --no-deps --require-hashes --only-binary :all: -r requirements.lock
COPY pyproject.toml README.md LICENSE ./
COPY ipcore ipcore
COPY service service
RUN /opt/venv/bin/pip install --quiet --no-deps --no-build-isolation --no-index .

FROM ${PYTHON_IMAGE}
ENV PATH=/opt/venv/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    IPFIT_HOST=0.0.0.0 \
    IPFIT_DATA_DIR=/data
COPY --from=builder /opt/venv /opt/venv
RUN install -d -o 10001 -g 10001 /data
VOLUME /data
USER 10001:10001
WORKDIR /data
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=5s --start-period=30s CMD ["ipfit", "healthcheck"]
ENTRYPOINT ["ipfit"]
CMD ["serve"]
